//! Removal of slivers by moving vertices.
//!
//! **Statement.** The quality of a cell is the smallest sine of its angles (in space: dihedral angles), negative if
//! the cell is inverted. While there are cells below a target, the algorithm searches for a better position for each
//! of their vertices in turn. It tries a fixed set of directions with halving steps. The vertex moves to the position
//! at which the worst cell around it is best, if this position is better than the current one.
//! - Cells and faces keep their vertices, so the mesh still conforms. Points on facets move in their plane. Corners and
//!   points on segments do not move.
//! - A vertex moves only if every cell around it remains positively oriented (exact sign). No radius-edge ratio
//!   around it may rise above the larger of the bound and the worst previous ratio there.
//! - The mesh is no longer Delaunay where points have moved.
//!
//! **Source.** Freitag and Ollivier-Gooch (1997) for optimisation-based smoothing, Klingner and Shewchuk (2007) for
//! the sine. **Departures.** A pattern search replaces the linear programs, because it needs no gradients and the
//! objective is not differentiable at its maxima.
//!
//! **Work and depth.** O(1) per sweep for each vertex of a bad cell, sequential, in the order of the cells.

use septet_geometry::measure::radius_edge_ratio;
use septet_geometry::point::{Point, Simplex, dist2};
use septet_geometry::predicates::{Sign, orientation};
use septet_geometry::range::scale;

use crate::domain::Domain;
use crate::frame::Frame;
use crate::mesh::{Carrier, Mesh};
use crate::space::Space;

/// The goal of an improvement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Cells with an angle below this, or above its supplement, in degrees, are improved.
    pub angle: f64,
    /// The radius-edge ratio that cells may reach.
    pub ratio: f64,
    /// The largest number of sweeps over the bad cells.
    pub sweeps: u32,
    /// Whether the boundary is fixed, including points in facets.
    pub fixed: bool,
}

impl Default for Target {
    fn default() -> Self {
        Target { angle: 16.0, ratio: 2.0, sweeps: 12, fixed: false }
    }
}

/// The result of an improvement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Improved {
    /// The number of bad cells before and after.
    pub bad: [u64; 2],
    /// The number of times that a vertex moved.
    pub moved: u64,
    /// The number of sweeps over the bad cells.
    pub sweeps: u32,
}

/// Improves a mesh of this domain in place.
pub fn improve<P: Space>(domain: &Domain<P>, mesh: &mut Mesh<P>, target: &Target) -> Improved {
    // Signs are exact in the scaled coordinates of the domain.
    let frame = domain.simplices.frame;
    let scaled = |mesh: &mut Mesh<P>, exponent: i32, way: &dyn Fn(P) -> P| {
        mesh.points.iter_mut().for_each(|p| *p = way(*p));
        mesh.sizes.iter_mut().for_each(|s| *s = scale(P::splat(*s), exponent).coord(0));
    };
    let exponent = domain.simplices.exponent;
    scaled(mesh, exponent, &|p| frame.inward(p));
    let done = sweep(domain, mesh, target);
    scaled(mesh, -exponent, &|p| frame.outward(p));
    done
}

fn sweep<P: Space>(domain: &Domain<P>, mesh: &mut Mesh<P>, target: &Target) -> Improved {
    let planes = normals(domain);
    let stars = Stars::new(mesh);
    let wanted = target.angle.to_radians().sin();
    // An improved star may contain new cells below the target, so each sweep checks all cells again.
    let below = |mesh: &Mesh<P>| -> Vec<u32> {
        (0..mesh.cells.len() as u32).filter(|&c| quality(mesh, c) < wanted).collect()
    };
    let mut bad = below(mesh);
    let mut done = Improved { bad: [bad.len() as u64; 2], ..Improved::default() };
    while !bad.is_empty() && done.sweeps < target.sweeps {
        let before = done.moved;
        for &cell in &bad {
            for v in mesh.cells[cell as usize].as_ref().to_vec() {
                if quality(mesh, cell) < wanted {
                    done.moved +=
                        u64::from(climb(mesh, &stars, (&planes, &domain.simplices.frame), v, wanted, target));
                }
            }
        }
        bad = below(mesh);
        done.sweeps += 1;
        if done.moved == before {
            break;
        }
    }
    done.bad[1] = bad.len() as u64;
    done
}

/// The cells around each vertex.
struct Stars {
    first: Vec<u32>,
    cells: Vec<u32>,
}

impl Stars {
    fn new<P: Point>(mesh: &Mesh<P>) -> Self {
        let mut first = vec![0u32; mesh.points.len() + 1];
        for &v in mesh.cells.iter().flat_map(AsRef::as_ref) {
            first[v as usize + 1] += 1;
        }
        for v in 0..mesh.points.len() {
            first[v + 1] += first[v];
        }
        let (mut at, mut cells) = (first.clone(), vec![0; mesh.cells.len() * P::Cell::LEN]);
        for (c, cell) in (0u32..).zip(&mesh.cells) {
            for &v in cell.as_ref() {
                cells[at[v as usize] as usize] = c;
                at[v as usize] += 1;
            }
        }
        Stars { first, cells }
    }

    fn of(&self, v: u32) -> &[u32] {
        &self.cells[self.first[v as usize] as usize..self.first[v as usize + 1] as usize]
    }
}

/// Returns the unit normal of each facet. Empty in the plane.
fn normals<P: Space>(domain: &Domain<P>) -> Vec<P> {
    let unit = |f: u32| {
        let n = crate::generate::normal_of(domain, f);
        n / n.norm2().sqrt()
    };
    (0..domain.facets.len() as u32).map(unit).collect()
}

/// Returns the smallest sine of the angles of a cell of the mesh.
fn quality<P: Point>(mesh: &Mesh<P>, cell: u32) -> f64 {
    least_sine(&mesh.corners(cell)[..P::Cell::LEN])
}

/// Returns the smallest sine of the angles of a cell, negative if the cell is inverted.
pub fn least_sine<P: Point>(p: &[P]) -> f64 {
    let rel = [p[1] - p[0], p[2] - p[0], if P::DIM == 3 { p[3] - p[0] } else { P::splat(0.0) }];
    let (w, _) = P::sphere_plane(&rel[..P::DIM]);
    if P::DIM == 2 {
        // sin = 2 area / (product of the two sides).
        let [a, b, c] = [dist2(p[1], p[2]), dist2(p[0], p[2]), dist2(p[0], p[1])];
        return w / (a * b).max(b * c).max(c * a).sqrt();
    }
    // The sine of the angle at an edge e is 3 volume |e| / (2 area area'). w is six volumes, and the areas are doubled
    // and squared.
    let twice = |a: usize, b: usize, c: usize| {
        let (u, v) = (p[b] - p[a], p[c] - p[a]);
        u.norm2() * v.norm2() - u.dot(v) * u.dot(v)
    };
    let areas = [twice(1, 2, 3), twice(0, 2, 3), twice(0, 1, 3), twice(0, 1, 2)];
    let mut least = f64::INFINITY;
    for (i, j, k, l) in [(0, 1, 2, 3), (0, 2, 1, 3), (0, 3, 1, 2), (1, 2, 0, 3), (1, 3, 0, 2), (2, 3, 0, 1)] {
        // The faces at edge ij are opposite k and l.
        least = least.min(dist2(p[i], p[j]) / (areas[k] * areas[l]));
    }
    w * least.sqrt()
}

/// Returns the search directions: the axes and the diagonals.
fn directions<P: Point>() -> Vec<P> {
    let mut found = Vec::new();
    for code in 1..3usize.pow(P::DIM as u32) {
        let mut d = P::splat(0.0);
        let mut rest = code;
        for i in 0..P::DIM {
            d.set_coord(i, [0.0, 1.0, -1.0][rest % 3]);
            rest /= 3;
        }
        found.push(d / d.norm2().sqrt());
    }
    found
}

/// Moves a vertex to a better position, if the search finds one. Returns `true` if it moved.
fn climb<P: Space>(
    mesh: &mut Mesh<P>,
    stars: &Stars,
    (normals, frame): (&[P], &Frame<P>),
    v: u32,
    wanted: f64,
    target: &Target,
) -> bool {
    let normal = match mesh.carriers[v as usize] {
        Carrier::Volume => None,
        Carrier::Facet(f) if P::DIM == 3 && !target.fixed => Some(normals[f as usize]),
        _ => return false,
    };
    let star = stars.of(v);
    let worst = |mesh: &Mesh<P>| star.iter().map(|&c| quality(mesh, c)).fold(f64::INFINITY, f64::min);
    let ratio = |mesh: &Mesh<P>| {
        let of = |&c: &u32| radius_edge_ratio(&mesh.corners(c)[..P::Cell::LEN]);
        star.iter().map(of).fold(0.0, f64::max)
    };
    let start = mesh.points[v as usize];
    let allowed = target.ratio.max(ratio(mesh));
    let mut best = (worst(mesh), start);
    let mut step = 0.25 * mesh.sizes[v as usize];
    let directions = directions::<P>();
    for _ in 0..SEARCHES {
        let centre = best.1;
        for &d in &directions {
            let d = normal.map_or(d, |n| d - n * n.dot(d));
            mesh.points[v as usize] = frame.snapped(centre + d * step);
            let found = worst(mesh);
            if found > best.0 && ratio(mesh) <= allowed && is_positive(mesh, star) {
                best = (found, mesh.points[v as usize]);
            }
        }
        if best.1 == centre {
            step *= 0.5;
        }
        if best.0 > 1.2 * wanted {
            break;
        }
    }
    mesh.points[v as usize] = best.1;
    best.1 != start
}

/// The number of rounds of a search.
const SEARCHES: u32 = 10;

fn is_positive<P: Point>(mesh: &Mesh<P>, cells: &[u32]) -> bool {
    cells.iter().all(|&c| orientation(&mesh.corners(c)[..P::Cell::LEN]) == Sign::Positive)
}
