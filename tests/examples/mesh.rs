//! Meshes a cube with a finer corner, and writes the mesh.
//!
//! `cargo run --release --example mesh -- cube.vtu`

use std::error::Error;
use std::path::PathBuf;

use glam::DVec3;
use septet::io::write::{WriteOptions, write};
use septet::mesh::{DomainKind, Input, InputFacet, Labelled, MeshSpec, check, make_of};

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).map_or_else(|| std::env::temp_dir().join("cube.vtu"), PathBuf::from);
    let corner = |i: u32| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
    let mut cube = Input::new(DomainKind::Complex, (0..8).map(corner).collect());
    for sides in [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]] {
        cube.facets.push(InputFacet { polygons: vec![sides.to_vec()], holes: Vec::new(), marker: 1 });
    }

    let mut spec = MeshSpec::default();
    spec.sizes.most = Some(0.25);
    let domain = check(&cube).map_err(|defects| format!("{} defects", defects.len()))?;
    let made = make_of(&domain, &spec)?;
    println!("{} points, {} tetrahedra", made.mesh.points.len(), made.mesh.cells.len());

    let labelled = Labelled::of(&domain, &made.mesh);
    write(&path, &labelled.view(), &WriteOptions::default(), &mut |_, _| {})?;
    println!("wrote {}", path.display());
    Ok(())
}
