//! Formats of other programs that are neither read nor written, and what to do instead.

/// A group of formats that are neither read nor written.
pub(super) struct Other {
    /// Their extensions.
    pub extensions: &'static [&'static str],
    /// What they are.
    pub what: &'static str,
    /// What to do to read such a file.
    pub read: &'static str,
    /// What to write instead.
    pub write: &'static str,
}

/// The advice to write a mesh for other programs.
const MESHIO: &str = "write .msh for meshio and Gmsh";

/// The advice to write a surface.
const SURFACE: &str = "write .obj or .ply for a surface";

const fn other(
    extensions: &'static [&'static str],
    what: &'static str,
    read: &'static str,
    write: &'static str,
) -> Other {
    Other { extensions, what, read, write }
}

/// Formats that are neither read nor written.
pub(super) const OTHERS: [Other; 20] = [
    other(
        &["vti", "vtr", "vts", "pvd", "cgns"],
        "a dataset of ParaView",
        "write .vtu with ParaView or meshio",
        "write .vtu for ParaView",
    ),
    other(
        &["pcd", "e57", "ptx"],
        "a point cloud",
        "convert the point cloud to .ply or .las, such as with CloudCompare",
        "write .ply or .xyz for points",
    ),
    other(
        &["h5", "hdf5", "parquet", "feather", "mat", "fits", "pkl"],
        "a file of arrays or tables",
        "read it in Python, and save the array with numpy.save as .npy",
        "write .npy for NumPy",
    ),
    other(
        &["xls", "xlsx", "ods"],
        "a spreadsheet",
        "export the sheet as .csv",
        "write .npy for the cells alone",
    ),
    other(&["json"], "JSON", "write the coordinates as .csv or .npy", "write .vtu for ParaView"),
    other(
        &["shp", "kml", "gpkg", "gpx"],
        "a layer of a geographic information system",
        "export its points as .csv, such as with QGIS or `ogr2ogr -f CSV -lco GEOMETRY=AS_XY`",
        "write .csv for points, or .obj for triangles",
    ),
    other(
        &["tif", "tiff", "grd"],
        "a raster",
        "convert it to rows of x, y and z with `gdal_translate -of XYZ`",
        SURFACE,
    ),
    other(&["3mf", "gltf", "glb", "dae"], "a surface", "export the surface as .obj or .ply", SURFACE),
    other(&["unv", "med", "cas"], "a mesh of a solver", "write .vtu or .msh with meshio", MESHIO),
    other(&["meshb"], "a binary file of Medit", "write .mesh or .vtu with meshio", "write .mesh"),
    other(
        &["step", "stp", "iges", "igs", "brep"],
        "a model of CAD",
        "write .msh or .stl with Gmsh",
        "write .stl or .off for a surface",
    ),
    other(
        &["pdb"],
        "atoms of a protein",
        "convert it to .xyz, such as with Open Babel",
        "write .xyz for points",
    ),
    other(
        &["dump"],
        "a dump of LAMMPS",
        "write the atoms as .xyz, such as with OVITO",
        "write .xyz for points",
    ),
    other(&["zip"], "an archive", "extract the file of points from it", "write a .gz file"),
    other(
        &["bz2"],
        "a compressed file",
        "decompress it with `bunzip2`, or compress it with gzip",
        "write a .gz file",
    ),
    other(
        &["zst"],
        "a compressed file",
        "decompress it with `unzstd`, or compress it with gzip",
        "write a .gz file",
    ),
    other(
        &["xz"],
        "a compressed file",
        "decompress it with `unxz`, or compress it with gzip",
        "write a .gz file",
    ),
    other(&["pdf", "png", "jpg"], "a picture", "give a file of coordinates", "write .vtu for ParaView"),
    other(&["sqlite", "db"], "a database", "export its rows as .csv", "write .csv for points"),
    other(
        &["shx", "dbf", "prj"],
        "a part of a shapefile",
        "export the points of the .shp file as .csv",
        "write .csv for points",
    ),
];
