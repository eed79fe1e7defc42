//! The restricted Delaunay triangulation.
//!
//! **Statement.** A cell belongs to the component of the domain that contains its circumcentre. The location is
//! exact, and an infinite circumcentre lies outside. The circumcentre of a cell that is flat up to rounding may be
//! anywhere between the circumcentres of its neighbours. Such a cell counts as outside if possible. Faces of the
//! boundary lie between cells of different components, or between a component and the outside. The dual edge of such
//! a face, which is the segment between the circumcentres or the ray that leaves the hull, meets the surface.

use septet_geometry::incremental::facet_without;
use septet_geometry::measure::circumcentre;
use septet_geometry::point::{Point, Simplex, dist2, lex_cmp};
use septet_geometry::predicates::orientation;

use super::surface::{Surface, SurfacePoint};
use crate::generate::balls::Ball;
use crate::generate::cell_labels::CellLabels;
use crate::generate::facets::circumcircle;
use crate::generate::generator::Generator;
use crate::generate::machine::{Delaunay, MeshMachine};
use crate::sides::Location;
use crate::space::Space;

/// The dual edge of a face: a segment or ray of the Voronoi diagram.
#[derive(Clone, Copy, Debug)]
struct DualEdge<P> {
    /// The cells on the two sides of the face; the second is `u32::MAX` across the hull.
    cells: [u32; 2],
    /// The vertex of the first cell that is opposite the face.
    apex: u32,
    /// The corners of the face.
    face: [P; 3],
}

/// A face of the boundary, and its surface ball.
#[derive(Clone, Copy, Debug)]
pub(super) struct RestrictedFace<P> {
    /// Its vertices, ascending.
    pub(super) vertices: [u32; 3],
    /// The adjacent cells, with `u32::MAX` across the hull.
    pub(super) cells: [u32; 2],
    /// The point s at which its dual edge meets the surface.
    pub(super) place: SurfacePoint<P>,
    /// The radius of the surface ball, whose centre is s.
    pub(super) radius: f64,
    /// The centre of the face's circumcircle.
    pub(super) centre: P,
}

/// A triangulation with its boundary.
pub(super) struct Restricted<P: Point> {
    pub(super) delaunay: Delaunay<P::Cell>,
    pub(super) labels: CellLabels,
    /// The circumcentres.
    pub(super) centres: Vec<P>,
    /// The boundary, ascending by vertices.
    pub(super) faces: Vec<RestrictedFace<P>>,
}

/// The ratio below which a cell is flat up to rounding: six times its volume, divided by the product of three of its
/// edges. The circumcentre of a flat cell may be anywhere on a line.
const FLAT: f64 = 1e-10;

/// The tolerance for cocircular corners of a flat cell. It bounds the power of a corner with respect to the circle of
/// the other corners, relative to the squared radius.
const CIRCULAR: f64 = 1e-6;

/// The offset of the centre of a cocircular flat cell from its circle, relative to the radius.
const ASIDE: f64 = 1e-6;

/// The number of cells per item of a parallel map.
const CHUNK: usize = 1024;

impl<P: Space> Restricted<P> {
    /// Labels the cells and finds the boundary.
    pub(super) fn new<M: MeshMachine<P> + Sync>(
        generator: &Generator<'_, P, M>,
        surface: &Surface<P>,
        delaunay: Delaunay<P::Cell>,
    ) -> Self {
        let numbers: Vec<u32> = (0..delaunay.cells.len() as u32).collect();
        let chunks: Vec<&[u32]> = numbers.chunks(CHUNK).collect();
        let one = |&i: &u32| located(generator, &delaunay.cells[i as usize]);
        let found = generator.machine.map(&chunks, |chunk| chunk.iter().map(one).collect::<Vec<_>>());
        let found: Vec<(P, Option<u32>)> = found.into_iter().flatten().collect();
        let flat = |&i: &u32| found[i as usize].1.is_none();
        let flat: Vec<u32> = numbers.iter().copied().filter(flat).collect();
        let far = 2.0 * surface.diagonal();
        let placed = generator.machine.map(&flat, |&i| flattened(generator, &delaunay, &found, far, i));
        let (mut centres, of): (Vec<P>, Vec<_>) = found.into_iter().unzip();
        let mut labels = CellLabels { of: of.into_iter().map(|l| l.unwrap_or(CellLabels::OUT)).collect() };
        for (&i, (centre, label)) in flat.iter().zip(placed) {
            (centres[i as usize], labels.of[i as usize]) = (centre, label);
        }
        let mut made = Restricted { delaunay, labels, centres, faces: Vec::new() };
        let found = generator.machine.map(&chunks, |chunk| {
            chunk.iter().flat_map(|&i| made.faces_of(generator, surface, i)).collect::<Vec<_>>()
        });
        made.faces = found.into_iter().flatten().collect();
        made.faces.sort_unstable_by_key(|f| f.vertices);
        made
    }

    /// Returns the boundary faces of a cell inside the domain. A face between two such cells is returned only once.
    fn faces_of<M: MeshMachine<P> + Sync>(
        &self,
        generator: &Generator<'_, P, M>,
        surface: &Surface<P>,
        i: u32,
    ) -> Vec<RestrictedFace<P>> {
        let mut found = Vec::new();
        if !self.labels.is_inside(i) {
            return found;
        }
        let across = &self.delaunay.neighbours[i as usize];
        let label = |j: u32| if j == u32::MAX { CellLabels::OUT } else { self.labels.of[j as usize] };
        for (slot, &j) in across.as_ref().iter().enumerate() {
            if label(j) == label(i) || label(j) != CellLabels::OUT && j < i {
                continue;
            }
            found.extend(self.face(generator, surface, i, slot, true));
        }
        found
    }

    /// Returns the face of a cell opposite a vertex, if its dual edge crosses the surface. If rounding hides the
    /// crossing and `always` is set, the point of the surface nearest to an end of the dual edge replaces the
    /// crossing.
    fn face<M: MeshMachine<P> + Sync>(
        &self,
        generator: &Generator<'_, P, M>,
        surface: &Surface<P>,
        i: u32,
        slot: usize,
        always: bool,
    ) -> Option<RestrictedFace<P>> {
        let (cell, j) =
            (&self.delaunay.cells[i as usize], self.delaunay.neighbours[i as usize].as_ref()[slot]);
        let apex = cell.as_ref()[slot];
        let mut vertices = [0; 3];
        vertices.copy_from_slice(facet_without::<P>(cell, apex).as_ref());
        vertices.sort_unstable();
        let corners = vertices.map(|v| generator.vertices.points[v as usize]);
        let [a, b, c] = corners;
        if !always && are_collinear(&corners) {
            return None;
        }
        let centre = circumcircle(a, b, c).centre;
        let dual = DualEdge { cells: [i, j], apex, face: corners };
        let place = self.crossing(generator, surface, &dual, always)?;
        let radius = dist2(place.at, a).sqrt();
        Some(RestrictedFace { vertices, cells: [i, j], place, radius, centre })
    }

    /// Returns the point at which the dual edge of a face meets the surface.
    fn crossing<M: MeshMachine<P> + Sync>(
        &self,
        generator: &Generator<'_, P, M>,
        surface: &Surface<P>,
        dual: &DualEdge<P>,
        always: bool,
    ) -> Option<SurfacePoint<P>> {
        let &DualEdge { cells: [i, j], apex, face: [a, b, c] } = dual;
        let label = |j: u32| if j == u32::MAX { CellLabels::OUT } else { self.labels.of[j as usize] };
        let from = self.centres[i as usize];
        let to = match j {
            u32::MAX => {
                beyond(&[a, b, c], generator.vertices.points[apex as usize], from, surface.diagonal())
            }
            j => self.centres[j as usize],
        };
        // The rounding must not depend on which cell comes first.
        let swap =
            (label(j) == CellLabels::OUT) == (label(i) == CellLabels::OUT) && lex_cmp(&to, &from).is_lt();
        let (from, to) = if swap { (to, from) } else { (from, to) };
        // The circumcentres of thin cells have large rounding errors. Dual edges are projected to the axis of the face,
        // so that s has the same distance from all of its corners.
        let centre = circumcircle(a, b, c).centre;
        let normal = P::hull_normal(&[b - a, c - a]);
        let axis = normal / normal.norm2().sqrt();
        let [from, to] = [from, to].map(|x| centre + axis * axis.dot(x - centre));
        let nearest = || if always { surface.nearer(from, to) } else { None };
        surface.crossing(from, to, a).or_else(nearest)
    }

    /// Considers the faces around each edge whose dual edges cross the surface an even number of times. These are not
    /// on the boundary. For each edge, returns the face with the largest surface ball. The edges are sorted and have
    /// ascending ends.
    pub(super) fn crossed_twice<M: MeshMachine<P> + Sync>(
        &self,
        generator: &Generator<'_, P, M>,
        surface: &Surface<P>,
        edges: &[[u32; 2]],
    ) -> Vec<Option<RestrictedFace<P>>> {
        let mut largest: Vec<Option<RestrictedFace<P>>> = vec![None; edges.len()];
        let label = |j: u32| if j == u32::MAX { CellLabels::OUT } else { self.labels.of[j as usize] };
        for (i, cell) in (0u32..).zip(&self.delaunay.cells) {
            let mut row = [0; 4];
            row.copy_from_slice(cell.as_ref());
            for (slot, &j) in self.delaunay.neighbours[i as usize].as_ref().iter().enumerate() {
                if label(j) != label(i) || j != u32::MAX && j < i {
                    continue;
                }
                let mut face: Vec<u32> = row.iter().copied().filter(|&v| v != row[slot]).collect();
                face.sort_unstable();
                let around = [[face[0], face[1]], [face[0], face[2]], [face[1], face[2]]];
                for e in around.into_iter().filter_map(|e| edges.binary_search(&e).ok()) {
                    let Some(new) = self.face(generator, surface, i, slot, false) else { break };
                    let order = |f: &RestrictedFace<P>| {
                        new.radius.total_cmp(&f.radius).then(f.vertices.cmp(&new.vertices))
                    };
                    if largest[e].is_none_or(|f| order(&f).is_gt()) {
                        largest[e] = Some(new);
                    }
                }
            }
        }
        largest
    }

    /// Returns `true` if the face is shared by cells of two components.
    pub(super) fn is_shared(&self, face: &RestrictedFace<P>) -> bool {
        face.cells[1] != u32::MAX && self.labels.is_inside(face.cells[1])
    }
}

/// Returns the circumcentre of a cell and the component that contains it. The component is `None` if the cell is flat
/// up to rounding.
fn located<P: Space, M: MeshMachine<P> + Sync>(
    generator: &Generator<'_, P, M>,
    cell: &P::Cell,
) -> (P, Option<u32>) {
    // The rounding must not depend on the order in which a machine returns the vertices.
    let mut cell = *cell;
    cell.as_mut().sort_unstable();
    let corners = generator.corners(&cell);
    let centre = circumcentre(&corners[..P::Cell::LEN]);
    let edges = [1, 2, 3].map(|i| corners[i] - corners[0]);
    let volume = P::hull_normal(&edges[..2]).dot(edges[2]).abs();
    let product: f64 = edges.iter().map(|e| e.norm2()).product();
    if volume * volume <= FLAT * FLAT * product || !centre.norm2().is_finite() {
        return (centre, None);
    }
    (centre, Some(label_at(generator, centre)))
}

fn label_at<P: Space, M: MeshMachine<P> + Sync>(generator: &Generator<'_, P, M>, at: P) -> u32 {
    let domain = generator.domain;
    match domain.sides.locate(domain.points(), at) {
        Some(Location::Component(c)) if domain.components[c as usize].inside => c,
        _ => CellLabels::OUT,
    }
}

/// Returns the two possible heights of the circumcentre of a flat cell above its largest face. By default, the exact
/// sign of the cell selects the side, and the distance is `far`. If the apex is cocircular up to rounding, the heights
/// are small and on both sides.
fn heights<P: Space>(face: [P; 3], apex: P, axis: P, ball: &Ball<P>, far: f64) -> [f64; 2] {
    let power = dist2(apex, ball.centre) - ball.radius2;
    if power.abs() <= CIRCULAR * ball.radius2 {
        return [ASIDE, -ASIDE].map(|t| t * ball.radius2.sqrt());
    }
    let [a, b, c] = face;
    let side = |p: P| orientation(&[a, b, c, p]);
    let is_above = side(apex) == side(ball.centre + axis * ball.radius2.sqrt());
    [if is_above == (power > 0.0) { far } else { -far }; 2]
}

/// Returns the circumcentre of a flat cell, and its label. If its corners are cocircular up to rounding, the
/// circumcentre is placed next to the centre of the circle, on the outer side if possible. No flat cell then remains
/// on the boundary. Otherwise, the circumcentre is far away. It always lies between the circumcentres of the
/// neighbours below and above.
fn flattened<P: Space, M: MeshMachine<P> + Sync>(
    generator: &Generator<'_, P, M>,
    delaunay: &Delaunay<P::Cell>,
    centres: &[(P, Option<u32>)],
    far: f64,
    i: u32,
) -> (P, u32) {
    let mut cell = delaunay.cells[i as usize];
    cell.as_mut().sort_unstable();
    let face_without = |v: u32| {
        let mut others = cell.as_ref().iter().copied().filter(|&w| w != v);
        [(); 3].map(|()| generator.vertices.points[others.next().unwrap_or_default() as usize])
    };
    let normal = |[a, b, c]: [P; 3]| P::hull_normal(&[b - a, c - a]);
    let faces = cell.as_ref().iter().map(|&v| face_without(v));
    let Some(face) = faces.max_by(|f, g| normal(*f).norm2().total_cmp(&normal(*g).norm2())) else {
        return (P::default(), CellLabels::OUT);
    };
    let axis = normal(face) / normal(face).norm2().sqrt();
    let ball = circumcircle(face[0], face[1], face[2]);
    let mut range = [f64::NEG_INFINITY, f64::INFINITY];
    let row = &delaunay.cells[i as usize];
    for (&v, &j) in row.as_ref().iter().zip(delaunay.neighbours[i as usize].as_ref()) {
        let Some(&(centre, Some(_))) = centres.get(j as usize) else { continue };
        let apex = delaunay.cells[j as usize].as_ref().iter().find(|w| !row.as_ref().contains(w));
        let [a, ..] = face_without(v);
        let Some(&apex) = apex else { continue };
        let (side, at) =
            (axis.dot(generator.vertices.points[apex as usize] - a), axis.dot(centre - ball.centre));
        if side > 0.0 {
            range[1] = range[1].min(at);
        } else {
            range[0] = range[0].max(at);
        }
    }
    let apex =
        cell.as_ref().iter().map(|&v| generator.vertices.points[v as usize]).find(|p| !face.contains(p));
    let heights = heights(face, apex.unwrap_or(face[0]), axis, &ball, far);
    let places = heights.map(|t| t.max(range[0]).min(range[1]));
    let [p, q] = places.map(|t| (ball.centre + axis * t, label_at(generator, ball.centre + axis * t)));
    if q.1 > p.1 { q } else { p }
}

/// Returns `true` if the corners of a face are collinear up to rounding. Its axis and all points on the axis are then
/// arbitrary.
fn are_collinear<P: Space>(&[a, b, c]: &[P; 3]) -> bool {
    P::hull_normal(&[b - a, c - a]).norm2() <= FLAT * FLAT * (b - a).norm2() * (c - a).norm2()
}

/// Returns the end of the ray from a circumcentre across a face of the hull.
fn beyond<P: Space>(&[a, b, c]: &[P; 3], apex: P, from: P, diagonal: f64) -> P {
    let normal = P::hull_normal(&[b - a, c - a]);
    let outwards = if normal.dot(apex - a) > 0.0 { normal * -1.0 } else { normal };
    from + outwards * (2.0 * diagonal / normal.norm2().sqrt())
}
