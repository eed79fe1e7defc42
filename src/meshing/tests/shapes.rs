//! Domains for tests.

use glam::DVec3;

use crate::input::{DomainKind, Input, InputFacet, InputSegment};

/// Corner `i` of the box between two points: bit 0 is x, bit 1 y, bit 2 z.
fn corner(low: DVec3, high: DVec3, i: u32) -> DVec3 {
    let pick = |bit: u32, a: f64, b: f64| if i >> bit & 1 == 0 { a } else { b };
    DVec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z))
}

/// The squares of a box.
pub const SQUARES: [[u32; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

/// Adds a box of six facets.
pub fn add_box(input: &mut Input<DVec3>, low: DVec3, high: DVec3) {
    let base = input.points.len() as u32;
    input.points.extend((0..8).map(|i| corner(low, high, i)));
    for square in SQUARES {
        facet(input, &[&square.map(|v| v + base)]);
    }
}

/// Adds a facet of these polygons.
pub fn facet(input: &mut Input<DVec3>, polygons: &[&[u32]]) {
    let polygons = polygons.iter().map(|p| p.to_vec()).collect();
    input.facets.push(InputFacet { polygons, holes: Vec::new(), marker: 0 });
}

/// Adds a segment.
pub fn segment(input: &mut Input<DVec3>, ends: [u32; 2]) {
    input.segments.push(InputSegment { ends, marker: 0 });
}

/// A cube of side 4.
pub fn cube() -> Input<DVec3> {
    let mut input = Input::new(DomainKind::Complex, Vec::new());
    add_box(&mut input, DVec3::ZERO, DVec3::splat(4.0));
    input
}

/// The boundary of a cube of side 4 as triangles.
pub fn cube_surface() -> Input<DVec3> {
    let cube = cube();
    let faces = SQUARES.iter().flat_map(|&[a, b, c, d]| [vec![a, b, c], vec![a, c, d]]);
    Input::surface(cube.points, faces)
}

/// Appends the points and faces of another surface.
pub fn join(a: &Input<DVec3>, b: &Input<DVec3>, shift: DVec3, scale: f64) -> Input<DVec3> {
    let mut both = a.clone();
    let base = both.points.len() as u32;
    both.points.extend(b.points.iter().map(|&p| p * scale + shift));
    for f in &b.facets {
        let polygons = f.polygons.iter().map(|p| p.iter().map(|v| v + base).collect()).collect();
        both.facets.push(InputFacet { polygons, ..f.clone() });
    }
    both
}
