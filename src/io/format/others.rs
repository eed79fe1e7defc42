//! Formats of other programs that are neither read nor written, and what to do instead.

/// Extensions of formats that are neither read nor written: the extensions, what to do to read such a file, and what to
/// write instead.
pub(super) const OTHERS: [(&[&str], &str, &str); 8] = [
    (
        &["vtp", "vti", "vtr", "vts", "pvd", "xdmf", "xmf", "ex2", "exo", "cgns"],
        "write .vtu with ParaView or meshio",
        "write .vtu for ParaView",
    ),
    (&["las", "laz", "pcd", "e57"], "convert the point cloud to .ply", "write .ply or .xyz for points"),
    (
        &["npz", "h5", "hdf5", "parquet", "feather", "mat", "fits", "pkl"],
        "save the array with numpy.save as .npy",
        "write .npy for NumPy",
    ),
    (&["xls", "xlsx", "ods"], "export the sheet as .csv", "write .npy for the cells alone"),
    (
        &["3mf", "gltf", "glb", "dae"],
        "export the surface as .obj or .ply",
        "write .stl or .off for a surface",
    ),
    (
        &["bdf", "inp", "unv", "med", "cas"],
        "write .vtu or .msh with meshio",
        "write .msh for meshio and Gmsh",
    ),
    (
        &["step", "stp", "iges", "igs", "brep"],
        "write .msh or .stl with Gmsh",
        "write .stl or .off for a surface",
    ),
    (&["svg", "pdf", "png"], "", "write .vtu for ParaView"),
];
