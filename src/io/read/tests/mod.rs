//! Tests of the readers.

mod binary;
mod cells;
mod columns;
mod dimensions;
mod formats;
mod hostile;
mod loading;
mod maps;
mod mesh_sizes;
mod mutations;
mod raw;
mod reports;
mod surfaces;
mod tables;
mod terrain;
mod vtk;
mod weights;

use std::path::Path;

use super::dispatch::{cell_list, points};
use super::{CellFile, CellOptions, InputError, PointFile, ReadOptions};
use septet_core::Door;
use septet_core::model::Points;

/// Default options.
const PLAIN: ReadOptions = with(None, false);
/// Drops invalid points.
const SKIP: ReadOptions = with(None, true);
/// `-d 2` and `-d 3`.
const TWO: ReadOptions = with(Some(2), false);
const THREE: ReadOptions = with(Some(3), false);

const fn with(dimension: Option<usize>, skip_invalid: bool) -> ReadOptions {
    ReadOptions {
        dimension,
        format: None,
        raw: None,
        skip_invalid,
        columns: None,
        keep_columns: false,
        terrain: false,
        weights: None,
    }
}

fn parse(name: &str, data: impl AsRef<[u8]>, options: &ReadOptions) -> Result<PointFile, InputError> {
    points(Path::new(name), data.as_ref(), options)
}

fn good(name: &str, data: impl AsRef<[u8]>) -> PointFile {
    good_with(name, data, &PLAIN)
}

fn good_with(name: &str, data: impl AsRef<[u8]>, options: &ReadOptions) -> PointFile {
    parse(name, data, options).unwrap_or_else(|error| panic!("{error}"))
}

fn bad(name: &str, data: impl AsRef<[u8]>) -> InputError {
    bad_with(name, data, &PLAIN)
}

fn bad_with(name: &str, data: impl AsRef<[u8]>, options: &ReadOptions) -> InputError {
    match parse(name, data, options) {
        Ok(file) => panic!("read as {file:?}"),
        Err(error) => {
            assert!(error.to_string().contains(name), "{error}");
            error
        }
    }
}

/// Returns the message and, after a line break, the remedy in the words of the shell.
fn report(error: &InputError) -> String {
    let remedy = error.remedy().map(|remedy| remedy.spelled(Door::Shell));
    format!("{error}\n{}", remedy.unwrap_or_default())
}

fn parse_cells(name: &str, data: impl AsRef<[u8]>, options: &CellOptions) -> Result<CellFile, InputError> {
    cell_list(Path::new(name), data.as_ref(), options)
}

fn good_cells(name: &str, data: impl AsRef<[u8]>) -> CellFile {
    parse_cells(name, data, &CellOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn bad_cells(name: &str, data: impl AsRef<[u8]>) -> InputError {
    parse_cells(name, data, &CellOptions::default()).expect_err("must be refused")
}

fn plane(file: &PointFile) -> Vec<[f64; 2]> {
    match &file.points {
        Points::Plane(points) => points.iter().map(glam::DVec2::to_array).collect(),
        other => panic!("points of dimension {}", other.dimension()),
    }
}

fn space(file: &PointFile) -> Vec<[f64; 3]> {
    match &file.points {
        Points::Space(points) => points.iter().map(glam::DVec3::to_array).collect(),
        other => panic!("points of dimension {}", other.dimension()),
    }
}

fn noted(notes: &[String], part: &str) -> bool {
    notes.iter().any(|note| note.contains(part))
}

/// Four corners, as little-endian bytes of the number type.
macro_rules! bytes_of {
    ($kind:ty, $convert:ident, $values:expr) => {
        $values.iter().flat_map(|v| (*v as $kind).$convert()).collect::<Vec<u8>>()
    };
}
use bytes_of;

const CORNERS: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.25, 0.5, -2.0]];

fn npy(header: &str, data: &[u8]) -> Vec<u8> {
    let mut file = b"\x93NUMPY\x01\x00".to_vec();
    file.extend((header.len() as u16).to_le_bytes());
    file.extend(header.as_bytes());
    file.extend(data);
    file
}

fn npy_f8() -> Vec<u8> {
    let flat = CORNERS.concat();
    npy(
        "{'descr': '<f8', 'fortran_order': False, 'shape': (4, 3), }   \n",
        &bytes_of!(f64, to_le_bytes, flat),
    )
}

fn ply_binary(big: bool) -> Vec<u8> {
    let order = if big { "big" } else { "little" };
    let mut file = format!(
        "ply\nformat binary_{order}_endian 1.0\ncomment c\nelement odd 2\nproperty list uchar short items\n\
         element vertex 4\nproperty uchar red\nproperty double x\nproperty float y\nproperty float z\n\
         property list int uchar more\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes();
    file.extend([1, 7, 7, 0]);
    for (i, p) in CORNERS.iter().enumerate() {
        let (x, y, z, n) = (p[0], p[1] as f32, p[2] as f32, i as i32);
        file.push(255);
        if big {
            file.extend(x.to_be_bytes());
            file.extend(y.to_be_bytes());
            file.extend(z.to_be_bytes());
            file.extend(n.to_be_bytes());
        } else {
            file.extend(x.to_le_bytes());
            file.extend(y.to_le_bytes());
            file.extend(z.to_le_bytes());
            file.extend(n.to_le_bytes());
        }
        file.extend(vec![9; i]);
    }
    file
}

fn stl_binary(head: &[u8]) -> Vec<u8> {
    let mut file = head.to_vec();
    file.resize(80, b' ');
    file.extend(2_u32.to_le_bytes());
    for facet in [[0, 1, 2], [0, 2, 3]] {
        file.extend([0; 12]);
        for corner in facet {
            file.extend(bytes_of!(f32, to_le_bytes, CORNERS[corner]));
        }
        file.extend([0; 2]);
    }
    file
}

/// One tetrahedron on the corners and one surface triangle; arrays appended raw.
fn vtu_raw(wide: bool) -> Vec<u8> {
    let mut data = Vec::new();
    let mut offsets = Vec::new();
    let flat = CORNERS.concat();
    let arrays = [
        bytes_of!(f64, to_le_bytes, flat),
        bytes_of!(i64, to_le_bytes, [0, 1, 2, 3, 0, 1, 2]),
        bytes_of!(i64, to_le_bytes, [4, 7]),
        vec![10, 5],
    ];
    for array in arrays {
        offsets.push(data.len());
        if wide {
            data.extend((array.len() as u64).to_le_bytes());
        } else {
            data.extend((array.len() as u32).to_le_bytes());
        }
        data.extend(array);
    }
    let header = if wide { " header_type=\"UInt64\"" } else { "" };
    let mut file = format!(
        "<?xml version=\"1.0\"?>\n<!-- a > b -->\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\"{header}>\n\
         <UnstructuredGrid><Piece NumberOfPoints=\"4\" NumberOfCells=\"2\">\n\
         <Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"appended\" offset=\"{}\"/></Points>\n\
         <Cells><DataArray type=\"Int64\" Name=\"connectivity\" format=\"appended\" offset=\"{}\"/>\n\
         <DataArray type=\"Int64\" Name=\"offsets\" format=\"appended\" offset=\"{}\"/>\n\
         <DataArray type=\"UInt8\" Name=\"types\" format=\"appended\" offset=\"{}\"></DataArray></Cells>\n\
         </Piece></UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n   _",
        offsets[0], offsets[1], offsets[2], offsets[3]
    )
    .into_bytes();
    file.extend(data);
    file.extend(b"\n</AppendedData>\n</VTKFile>\n");
    file
}

/// Returns the same mesh with inline arrays, which a function of their bytes and numbers writes.
fn vtu_inline(root: &str, format: &str, mut write: impl FnMut(&[u8], &str) -> String) -> String {
    let flat = CORNERS.concat();
    let points = write(&bytes_of!(f64, to_le_bytes, flat), "0 0 0 1 0 0\n0 1 0 0.25 0.5 -2");
    let connectivity = write(&bytes_of!(i64, to_le_bytes, [0, 1, 2, 3, 0, 1, 2]), "0 1 2 3 0 1 2");
    let offsets = write(&bytes_of!(i64, to_le_bytes, [4, 7]), "4 7");
    let types = write(&[10, 5], "10 5");
    format!(
        "<VTKFile type='UnstructuredGrid' byte_order='LittleEndian' {root}><UnstructuredGrid>\
         <Piece NumberOfPoints='4' NumberOfCells='2'><PointData><DataArray type='String' Name='x'> ? </DataArray></PointData>\
         <Points><DataArray type='Float64' Name='Points' NumberOfComponents='3' format='{format}'>\n{points}\n\
         <InformationKey name='N'><Value index='0'>abcdefghijklmnopqrstuvwxyz0123456789abcdefghijklmnopqrstuvwxyz0123456789abcdefghijklmnopqrstuvwxyz</Value></InformationKey></DataArray></Points>\
         <Cells><DataArray type='Int64' Name='connectivity' format='{format}'>{connectivity}</DataArray>\
         <DataArray type='Int64' Name='offsets' format='{format}'>{offsets}</DataArray>\
         <DataArray type='UInt8' Name='types' format='{format}'>{types}</DataArray></Cells>\
         </Piece></UnstructuredGrid></VTKFile>"
    )
}

const MSH2: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 1 \"a#b\"\n$EndPhysicalNames\n\
    $Nodes\n4\n10 0 0 0\n20 1 0 0\n15 0 1 0\n7 0.25 0.5 -2\n$EndNodes\n\
    $Elements\n3\n1 15 2 0 1 10\n2 2 2 0 1 10 20 15\n3 4 4 0 1 1 -2 10 20 15 7\n$EndElements\n";

const MSH41: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0 0\n$EndEntities\n\
    $Nodes\n2 4 1 4\n2 1 0 3\n1\n2\n3\n0 0 0\n1 0 0\n0 1 0\n3 1 1 1\n4\n0.25 0.5 -2 0.1 0.2 0.3\n$EndNodes\n\
    $Elements\n2 2 1 2\n2 1 2 1\n1 1 2 3\n3 1 4 1\n2 1 2 3 4\n$EndElements\n";

const MEDIT: &str = "MeshVersionFormatted 2\n\nDimension\n3\n# c\nVertices\n4\n0 0 0 0\n1 0 0 0\n0 1 0 0 0.25 0.5\n-2 0\n\
    Corners\n1\n1\nTriangles 1\n1 2 3 0\nTetrahedra\n1\n1 2 3 4 0\nEnd\n";

const STL_ASCII: &str = "solid it\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 0 1 0\n  endloop\n endfacet\n\
    facet normal 0 0 1\n outer loop\n vertex 0 0 -0.0\n vertex 0 1 0\n vertex 0.25 0.5 -2\n endloop\n endfacet\nendsolid it\n";
