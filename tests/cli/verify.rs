//! `septet verify` with one file, and of pieces that were altered.

use super::*;

/// The arrays of a piece.
#[derive(Clone, Default)]
struct Piece {
    ids: Vec<u64>,
    ghost_points: Vec<u8>,
    places: Vec<[f64; 3]>,
    cell_ids: Vec<u64>,
    owners: Vec<u64>,
    ghost_cells: Vec<u8>,
    cells: Vec<Vec<u64>>,
}

impl Piece {
    /// Reads a piece that septet wrote.
    fn read(path: &Path) -> Self {
        let bytes = fs::read(path).unwrap();
        let start = bytes.windows(7).position(|found| found == b"\"raw\">\n").unwrap();
        let start = start + bytes[start..].iter().position(|byte| *byte == b'_').unwrap() + 1;
        let head = String::from_utf8_lossy(&bytes[..start]).into_owned();
        let array = |section: &str, name: &str| -> &[u8] {
            let from = head.find(&format!("<{section}")).unwrap();
            let at = from + head[from..].find(&format!("Name=\"{name}\"")).unwrap();
            let offset = at + head[at..].find("offset=\"").unwrap() + 8;
            let offset: usize = head[offset..].split('"').next().unwrap().parse().unwrap();
            let data = &bytes[start + offset..];
            let length = u64::from_le_bytes(data[..8].try_into().unwrap()) as usize;
            &data[8..8 + length]
        };
        let words = |bytes: &[u8]| -> Vec<u64> {
            bytes.chunks(8).map(|word| u64::from_le_bytes(word.try_into().unwrap())).collect()
        };
        let places: Vec<f64> = words(array("Points", "Points")).into_iter().map(f64::from_bits).collect();
        let offsets = words(array("Cells", "offsets"));
        let corners = offsets.first().map_or(4, |first| *first as usize);
        let owners = array("CellData", "owner").chunks(4);
        Piece {
            ids: words(array("PointData", "GlobalPointIds")),
            ghost_points: array("PointData", "vtkGhostType").to_vec(),
            places: places.chunks(3).map(|place| place.try_into().unwrap()).collect(),
            cell_ids: words(array("CellData", "GlobalCellIds")),
            owners: owners.map(|word| u64::from(u32::from_le_bytes(word.try_into().unwrap()))).collect(),
            ghost_cells: array("CellData", "vtkGhostType").to_vec(),
            cells: words(array("Cells", "connectivity")).chunks(corners).map(<[u64]>::to_vec).collect(),
        }
    }

    /// Writes the piece as text.
    fn write(&self, path: &Path) {
        fn row<T: std::fmt::Debug>(kind: &str, name: &str, values: impl IntoIterator<Item = T>) -> String {
            let values: Vec<String> = values.into_iter().map(|value| format!("{value:?}")).collect();
            let components = if name == "Points" { " NumberOfComponents=\"3\"" } else { "" };
            format!(
                "<DataArray type=\"{kind}\" Name=\"{name}\"{components}>\n{}\n</DataArray>\n",
                values.join(" ")
            )
        }
        let corners = self.cells.first().map_or(4, Vec::len);
        let kind = if corners == 4 { 10 } else { 5 };
        let text = [
            "<VTKFile type=\"UnstructuredGrid\">\n<UnstructuredGrid>\n".to_owned(),
            format!("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n", self.ids.len(), self.cells.len()),
            "<PointData>\n".to_owned(),
            row("Int64", "GlobalPointIds", &self.ids),
            row("UInt8", "vtkGhostType", &self.ghost_points),
            "</PointData>\n<CellData>\n".to_owned(),
            if self.cell_ids.is_empty() {
                String::new()
            } else {
                row("Int64", "GlobalCellIds", &self.cell_ids)
            },
            row("UInt32", "owner", &self.owners),
            row("UInt8", "vtkGhostType", &self.ghost_cells),
            "</CellData>\n<Points>\n".to_owned(),
            row("Float64", "Points", self.places.as_flattened()),
            "</Points>\n<Cells>\n".to_owned(),
            row("Int64", "connectivity", self.cells.concat()),
            row("Int64", "offsets", (1..=self.cells.len()).map(|cell| cell * corners)),
            row("UInt8", "types", self.cells.iter().map(|_| kind)),
            "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n".to_owned(),
        ];
        fs::write(path, text.concat()).unwrap();
    }

    /// Removes a cell.
    fn drop_cell(&mut self, at: usize) {
        self.cells.remove(at);
        self.cell_ids.remove(at);
        self.owners.remove(at);
        self.ghost_cells.remove(at);
    }

    /// Inserts a copy of a cell after it.
    fn double_cell(&mut self, at: usize) {
        self.cells.insert(at, self.cells[at].clone());
        self.cell_ids.insert(at, self.cell_ids[at]);
        self.owners.insert(at, self.owners[at]);
        self.ghost_cells.insert(at, self.ghost_cells[at]);
    }

    /// Whether all vertices of a cell, and the cell itself, belong to this piece.
    fn is_inner(&self, cell: usize) -> bool {
        let is_own = |vertex: &u64| self.ghost_points[*vertex as usize] == 0;
        self.ghost_cells[cell] == 0 && self.cells[cell].iter().all(is_own)
    }

    /// Returns a place inside and one at the border of the piece.
    fn places(&self) -> Chosen {
        let cells = || 0..self.cells.len();
        let at = |vertex: u64| cells().filter(move |&cell| self.cells[cell].contains(&vertex));
        let vertex =
            (0..self.ids.len() as u64).find(|&vertex| at(vertex).all(|cell| self.is_inner(cell))).unwrap();
        let inner = at(vertex).next().unwrap();
        let outer = cells().find(|&cell| self.ghost_cells[cell] == 0 && !self.is_inner(cell)).unwrap();
        Chosen { vertex: vertex as usize, inner, outer }
    }
}

/// The places of alterations.
#[derive(Clone, Copy)]
struct Chosen {
    /// A point that is in no other piece.
    vertex: usize,
    /// A cell at this point.
    inner: usize,
    /// An own cell with points of other pieces.
    outer: usize,
}

/// Three pieces in a folder, and the last one, which is altered.
fn pieces(dimension: usize) -> (Place, PathBuf, Piece) {
    let place = Place::new();
    place.good(&format!("generate uniform -n 2000 -d {dimension} -q -o p.xyz"));
    place.good("triangulate p.xyz -q --workers 3 -o m.pvtu --with-owner");
    let path = place.path("m.pieces/0002.vtu");
    let piece = Piece::read(&path);
    assert!(piece.cells.len() > 100 && piece.ghost_cells.contains(&1), "{}", piece.cells.len());
    // The text of a piece is read as its bytes are.
    piece.write(&path);
    place.good("verify m.pvtu");
    place.good("verify p.xyz m.pvtu --perturbed");
    (place, path, piece)
}

#[test]
fn an_altered_piece_is_named() {
    type Alter = fn(&mut Piece, Chosen);
    let alterations: [(&str, i32, Alter); 15] = [
        ("coordinate", 3, |piece, chosen| {
            let own =
                piece.cells[chosen.outer].iter().find(|vertex| piece.ghost_points[**vertex as usize] == 0);
            piece.places[*own.unwrap() as usize][0] += 1e-9;
        }),
        ("ghost coordinate", 3, |piece, _| piece.places.last_mut().unwrap()[1] += 1e-9),
        ("inner coordinate", 4, |piece, chosen| {
            let cell = &piece.cells[chosen.inner];
            let other = cell.iter().find(|other| **other != chosen.vertex as u64).unwrap();
            piece.places[chosen.vertex] = piece.places[*other as usize];
        }),
        ("inner cell dropped", 3, |piece, chosen| piece.drop_cell(chosen.inner)),
        ("outer cell dropped", 3, |piece, chosen| piece.drop_cell(chosen.outer)),
        ("ghost cell dropped", 3, |piece, _| piece.drop_cell(piece.cells.len() - 1)),
        ("inner cell dropped without numbers", 4, |piece, chosen| {
            piece.drop_cell(chosen.inner);
            piece.cell_ids.clear();
        }),
        ("cell doubled", 3, |piece, chosen| piece.double_cell(chosen.inner)),
        ("cell doubled without numbers", 4, |piece, chosen| {
            piece.double_cell(chosen.inner);
            piece.cell_ids.clear();
        }),
        ("ghost cell doubled", 3, |piece, _| piece.double_cell(piece.cells.len() - 1)),
        ("ids swapped", 3, |piece, _| piece.ids.swap(0, 1)),
        ("ghost ids swapped", 3, |piece, _| {
            let last = piece.ids.len() - 1;
            piece.ids.swap(last - 1, last);
        }),
        ("worker", 3, |piece, chosen| piece.owners[chosen.inner] = 1),
        ("a ghost becomes an own cell", 3, |piece, _| *piece.ghost_cells.last_mut().unwrap() = 0),
        ("an own point becomes a ghost", 3, |piece, chosen| piece.ghost_points[chosen.vertex] = 1),
    ];
    for dimension in [2, 3] {
        let (place, path, whole) = pieces(dimension);
        for (label, exit, alter) in &alterations {
            let mut piece = whole.clone();
            let chosen = piece.places();
            alter(&mut piece, chosen);
            piece.write(&path);
            for line in ["verify m.pvtu", "verify p.xyz m.pvtu"] {
                let output = place.run(line);
                let talk = stderr(&output);
                // A point that moves has other coordinates than the input.
                let expected = if line.contains("p.xyz") && *label == "inner coordinate" { 3 } else { *exit };
                assert_eq!(code(&output), expected, "{dimension}D {label}: {talk}");
                assert!(talk.contains("m.pieces/0002.vtu"), "{dimension}D {label}: {talk}");
            }
        }
    }
}

#[test]
fn a_piece_that_is_cut_short_or_missing_is_named() {
    let (place, path, _) = pieces(3);
    place.good("triangulate p.xyz -q --workers 3 -o m.pvtu");
    let whole = fs::read(&path).unwrap();
    for length in [0, 100, 1000, whole.len() / 2, whole.len() - 400] {
        fs::write(&path, &whole[..length]).unwrap();
        place.fails("verify m.pvtu", 3, &["m.pieces/0002.vtu"]);
    }
    fs::remove_file(&path).unwrap();
    place.fails("verify m.pvtu", 3, &["m.pieces/0002.vtu", "no such file"]);
    fs::write(&path, &whole).unwrap();
    place.good("verify m.pvtu");
    let list = fs::read(place.path("m.pvtu")).unwrap();
    place.file("m.pvtu", &list[..list.len() - 80]);
    place.fails("verify m.pvtu", 3, &["m.pvtu"]);
}

#[test]
fn one_file_of_points_and_cells_is_enough() {
    let place = Place::new();
    place.good("generate clusters -n 300 -d 2 -q -o p2.xyz");
    place.good("generate uniform -n 300 -q -o p3.xyz");
    for name in ["vtu", "vtk", "msh", "msh22", "mesh", "vtu.gz"] {
        for points in ["p2.xyz", "p3.xyz"] {
            place.good(&format!("triangulate {points} -q -o m.{name}"));
            let talk = stderr(&place.good(&format!("verify m.{name} --perturbed --json v.json")));
            assert!(talk.contains("of its points: ") && talk.contains("300 points"), "{talk}");
            assert_eq!(place.json("v.json")["points_file"], format!("m.{name}"));
            assert_eq!(place.json("v.json")["cells_file"], format!("m.{name}"));
        }
    }
    for name in ["off", "obj", "ply"] {
        place.good(&format!("triangulate p2.xyz -q -o plane.{name}"));
        place.good(&format!("verify plane.{name}"));
        place.good(&format!("triangulate p3.xyz -q -o hull.{name}"));
        place.fails(&format!("verify hull.{name}"), 3, &["triangles", "three coordinates"]);
    }
    // Duplicates are points of a file, and no vertices.
    place.file("twice.xyz", "0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0\n1 1 1\n");
    place.good("triangulate twice.xyz -q --workers 2 -o t.vtu -o t.pvtu");
    place.good("verify t.vtu --perturbed");
    let talk = stderr(&place.good("verify t.pvtu"));
    assert!(talk.contains("5 points"), "{talk}");
    place.good("verify twice.xyz t.pvtu");
    place.file("other.xyz", "0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0\n1 1 2\n");
    place.fails("verify other.xyz t.pvtu", 3, &["t.pieces/000", "id 5", "other.xyz"]);
    place.file("fewer.xyz", "0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0\n");
    place.fails("verify fewer.xyz t.pvtu", 3, &["t.pieces/000", "id 5", "does not exist"]);
}

#[test]
fn flat_points_without_cells_are_no_triangulation() {
    let place = Place::new();
    for name in ["p2.vtu", "p2.vtk", "p2.vtu.gz"] {
        place.good(&format!("generate uniform -n 50 -d 2 -q -o {name}"));
        let failed = place.run(&format!("verify {name}"));
        assert_eq!(code(&failed), 4, "{name}");
        assert!(stderr(&failed).contains("there are no cells"), "{}", stderr(&failed));
    }
}

#[test]
fn one_file_without_points_or_cells_is_refused() {
    let place = Place::new();
    place.good("generate uniform -n 30 -q -o p.xyz");
    place.good("triangulate p.xyz -q -o m.npy -o m.ele");
    for name in ["p.xyz", "m.npy", "m.1.node", "m.ele"] {
        fs::copy(place.path("p.xyz"), place.path("m.1.node")).unwrap();
        place.fails(&format!("verify {name}"), 3, &[name, "septet verify POINTS CELLS"]);
    }
    place.fails("verify sample:uniform:9", 2, &["sample:uniform:9", "cells"]);
    place.fails("verify none.vtu", 3, &["none.vtu", "no such file"]);
}
