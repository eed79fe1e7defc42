//! The files of meshes of domains, with their groups, in the formats of solvers.

use std::fs;
use std::path::Path;
use std::process::Command;

use super::python;

/// Domains in space and in the plane, and options.
const DOMAINS: [(&str, &str); 3] =
    [("two-regions", "--size 0.9"), ("dangling", "--size 1"), ("map", "--size 0.7")];

/// The formats that hold groups. All but `.su2` hold quadratic cells.
const EXTENSIONS: [&str; 10] = ["vtu", "vtk", "msh", "msh22", "xdmf", "inp", "bdf", "exo", "su2", "1.ele"];

/// Returns a domain with other markers: facets get 1, 2 and so on where they have 0, but the first keeps it.
fn marked(domain: &str) -> String {
    let mut next = 0;
    let line = |line: &str| match line {
        "1 0 0" => {
            next += 1;
            format!("1 0 {}\n", next - 1)
        }
        _ => format!("{line}\n"),
    };
    domain.lines().map(line).collect()
}

fn septet(directory: &Path, words: &[&str]) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_septet"));
    let made = command.current_dir(directory).args(words).output().unwrap();
    assert!(made.status.success(), "{words:?}: {}", String::from_utf8_lossy(&made.stderr));
}

/// Cells, faces, edges and groups are the same for readers of other programs in each format, also with cells of order 2.
#[test]
#[ignore = "needs Python with vtk, meshio, h5py, netCDF4, pyvista, scipy, gmsh and numpy"]
fn solvers_read_meshes_with_groups() {
    let place = tempfile::tempdir().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let mut folders = Vec::new();
    for (name, options) in DOMAINS {
        let folder = place.path().join(name);
        fs::create_dir(&folder).unwrap();
        let domain = fs::read_to_string(root.join("domains/good").join(name).with_extension("poly")).unwrap();
        let is_plane = name == "map";
        fs::write(folder.join("d.poly"), marked(&domain)).unwrap();
        for (stem, order) in [("m", "1"), ("q", "2")] {
            let is_linear = order == "1";
            let held = EXTENSIONS.iter().filter(|e| is_linear || !["su2", "1.ele"].contains(e));
            let mut files: Vec<String> = held.map(|extension| format!("{stem}.{extension}")).collect();
            if is_linear && !is_plane {
                files.push("polyMesh".to_owned());
            }
            let mut words = vec!["mesh", "d.poly", "-q", "--order", order];
            words.extend(options.split(' '));
            words.extend(files.iter().flat_map(|file| ["-o", file]));
            septet(&folder, &words);
            // meshio does not know the ending .msh22.
            fs::copy(folder.join(format!("{stem}.msh22")), folder.join(format!("{stem}.v2.msh"))).unwrap();
        }
        folders.push(folder);
    }
    let script = root.join("foreign/check_solvers.py");
    let output = Command::new(python()).arg("-B").arg(script).args(&folders).output().unwrap();
    let printed = [output.stdout, output.stderr].map(|s| String::from_utf8_lossy(&s).into_owned()).concat();
    assert!(output.status.success() && printed.contains(" passed, 0 failed"), "{printed}");
    println!("{printed}");
}
