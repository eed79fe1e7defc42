//! Tests of the table of formats.

use super::others::OTHERS;
use super::*;

#[test]
fn an_extension_belongs_to_one_format() {
    let mut all: Vec<&str> = OTHERS.iter().flat_map(|other| other.extensions).copied().collect();
    for format in Format::ALL {
        let row = format.row();
        all.extend(row.extensions.iter().chain(row.ambiguous));
        for name in row.extensions {
            assert_eq!(name.parse(), Ok(*format));
            assert_eq!(Format::of_path(Path::new(&format!("a.{}.gz", name.to_uppercase()))), Some(*format));
        }
        assert!(row.roles.iter().all(|(role, _)| format.instead(*role).is_none()), "{format:?}");
        assert!(row.divided.iter().all(|role| format.has(*role)), "{format:?}");
    }
    let count = all.len();
    all.sort_unstable();
    all.dedup();
    assert_eq!(all.len(), count);
}

#[test]
fn advice_follows_the_extension() {
    for (name, role, advice) in [
        ("a.cgns", Role::Triangulation, "write .vtu for ParaView"),
        ("a.cgns.gz", Role::Points, "this is a dataset of ParaView: write .vtu with ParaView or meshio"),
        ("a.xdmf.gz", Role::Points, "write .vtu with ParaView or meshio"),
        ("a.vut", Role::Triangulation, "the nearest is .vtu"),
        ("a.cvs", Role::Points, "rename it if it is a .csv file"),
        ("a.npz", Role::Mesh, "write .npy for NumPy"),
        ("a.gltf", Role::Triangulation, "write .obj or .ply for a surface"),
        ("a.tsv", Role::PointSet, "write .xyz or .csv for text"),
        ("a.pvtu", Role::Points, "it only lists its pieces; give one of the .vtu files that it names"),
    ] {
        assert_eq!(role.advice(Path::new(name)).as_deref(), Some(advice), "{name}");
    }
    assert_eq!(Role::Points.advice(Path::new("a.zzzz")), None);
}

#[test]
fn names_are_those_of_the_use() {
    let error = Format::named("ele", Role::Points).unwrap_err();
    assert!(error.known.starts_with("node xyz txt csv") && !error.known.contains("ele"), "{error}");
    assert_eq!(Format::named("MSH2", Role::Triangulation), Ok(Format::Msh22));
    assert!(Format::named("xyz", Role::Triangulation).is_err());
}
