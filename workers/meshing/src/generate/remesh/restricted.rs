//! The restricted Delaunay triangulation.
//!
//! **Statement.** A cell belongs to the component of the domain that its circumcentre lies in, exactly located (an
//! infinite one lies outside). Faces of the boundary lie between cells of different components, outside among them; the
//! segment between the circumcentres, or the ray that leaves the hull, meets the surface.

use septet_geometry::incremental::facet_without;
use septet_geometry::measure::circumcentre;
use septet_geometry::point::{Point, Simplex, dist2, lex_cmp};

use super::surface::{Place, Surface};
use crate::generate::cells::Labels;
use crate::generate::facets::circumcircle;
use crate::generate::machine::{Machine, Triangulation};
use crate::generate::work::Work;
use crate::sides::Location;
use crate::space::Space;

/// A face of the boundary with its surface ball.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face<P> {
    /// Its vertices, ascending.
    pub(super) vertices: [u32; 3],
    /// The cells beside it, `u32::MAX` across the hull.
    pub(super) cells: [u32; 2],
    /// Where its dual edge meets the surface.
    pub(super) place: Place<P>,
    /// The radius of the ball around it.
    pub(super) radius: f64,
    /// The centre of the face's circumcircle.
    pub(super) centre: P,
}

/// A triangulation with its boundary.
pub(super) struct Restricted<P: Point> {
    pub(super) delaunay: Triangulation<P::Cell>,
    pub(super) labels: Labels,
    /// The circumcentres.
    pub(super) centres: Vec<P>,
    /// The boundary, ascending by vertices.
    pub(super) faces: Vec<Face<P>>,
}

/// Cells that are looked at as one item.
const CHUNK: usize = 1024;

impl<P: Space> Restricted<P> {
    /// Labels the cells and finds the boundary.
    pub(super) fn new<M: Machine<P> + Sync>(
        work: &Work<'_, P, M>,
        surface: &Surface<P>,
        delaunay: Triangulation<P::Cell>,
    ) -> Self {
        let numbers: Vec<u32> = (0..delaunay.cells.len() as u32).collect();
        let chunks: Vec<&[u32]> = numbers.chunks(CHUNK).collect();
        let one = |&i: &u32| located(work, &delaunay.cells[i as usize]);
        let found = work.machine.map(&chunks, |chunk| chunk.iter().map(one).collect::<Vec<_>>());
        let (centres, of): (Vec<P>, Vec<u32>) = found.into_iter().flatten().unzip();
        let labels = Labels { of };
        let mut made = Restricted { delaunay, labels, centres, faces: Vec::new() };
        let found = work.machine.map(&chunks, |chunk| {
            chunk.iter().flat_map(|&i| made.faces_of(work, surface, i)).collect::<Vec<_>>()
        });
        made.faces = found.into_iter().flatten().collect();
        made.faces.sort_unstable_by_key(|f| f.vertices);
        made
    }

    /// The faces of a cell inside on the boundary; those between two such cells once.
    fn faces_of<M: Machine<P> + Sync>(
        &self,
        work: &Work<'_, P, M>,
        surface: &Surface<P>,
        i: u32,
    ) -> Vec<Face<P>> {
        let mut found = Vec::new();
        if !self.labels.is_inside(i) {
            return found;
        }
        let across = &self.delaunay.neighbours[i as usize];
        let label = |j: u32| if j == u32::MAX { Labels::OUT } else { self.labels.of[j as usize] };
        for (slot, &j) in across.as_ref().iter().enumerate() {
            if label(j) == label(i) || label(j) != Labels::OUT && j < i {
                continue;
            }
            found.extend(self.face(work, surface, i, slot, true));
        }
        found
    }

    /// The face of a cell opposite a vertex, if its dual edge crosses the surface. (`always`: if rounding hides the crossing, an
    /// end of the edge is as good as on the surface, and the place is the one nearest to it.)
    fn face<M: Machine<P> + Sync>(
        &self,
        work: &Work<'_, P, M>,
        surface: &Surface<P>,
        i: u32,
        slot: usize,
        always: bool,
    ) -> Option<Face<P>> {
        let (cell, j) =
            (&self.delaunay.cells[i as usize], self.delaunay.neighbours[i as usize].as_ref()[slot]);
        let label = |j: u32| if j == u32::MAX { Labels::OUT } else { self.labels.of[j as usize] };
        let apex = cell.as_ref()[slot];
        let mut vertices = [0; 3];
        vertices.copy_from_slice(facet_without::<P>(cell, apex).as_ref());
        vertices.sort_unstable();
        let corners = vertices.map(|v| work.vertices.points[v as usize]);
        let from = self.centres[i as usize];
        let far = work.vertices.points[apex as usize];
        let to = match j {
            u32::MAX => beyond(&corners, far, from, surface.diagonal()),
            j => self.centres[j as usize],
        };
        let [a, b, c] = corners;
        let centre = circumcircle(a, b, c).centre;
        // Rounded alike whichever cell comes first.
        let swap = (label(j) == Labels::OUT) == (label(i) == Labels::OUT) && lex_cmp(&to, &from).is_lt();
        let (from, to) = if swap { (to, from) } else { (from, to) };
        // Centres of flat cells are badly rounded: their dual edges are put on the axis of the face, so that s is as far from all of
        // its corners.
        let normal = P::hull_normal(&[b - a, c - a]);
        let axis = normal / normal.norm2().sqrt();
        let [from, to] = [from, to].map(|x| centre + axis * axis.dot(x - centre));
        let nearest = || if always { surface.nearer(from, to) } else { None };
        let place = surface.crossing(from, to, a).or_else(nearest)?;
        let radius = dist2(place.at, a).sqrt();
        Some(Face { vertices, cells: [i, j], place, radius, centre })
    }

    /// For each of these edges (ends ascending, sorted) the face with the largest surface ball around it whose dual edge crosses the
    /// surface an even number of times and is no face of the boundary for that.
    pub(super) fn crossed_twice<M: Machine<P> + Sync>(
        &self,
        work: &Work<'_, P, M>,
        surface: &Surface<P>,
        edges: &[[u32; 2]],
    ) -> Vec<Option<Face<P>>> {
        let mut largest: Vec<Option<Face<P>>> = vec![None; edges.len()];
        let label = |j: u32| if j == u32::MAX { Labels::OUT } else { self.labels.of[j as usize] };
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
                    let Some(new) = self.face(work, surface, i, slot, false) else { break };
                    let order =
                        |f: &Face<P>| new.radius.total_cmp(&f.radius).then(f.vertices.cmp(&new.vertices));
                    if largest[e].is_none_or(|f| order(&f).is_gt()) {
                        largest[e] = Some(new);
                    }
                }
            }
        }
        largest
    }

    /// Do cells of two components share the face?
    pub(super) fn is_shared(&self, face: &Face<P>) -> bool {
        face.cells[1] != u32::MAX && self.labels.is_inside(face.cells[1])
    }
}

/// The circumcentre of a cell and the component that it lies in.
fn located<P: Space, M: Machine<P> + Sync>(work: &Work<'_, P, M>, cell: &P::Cell) -> (P, u32) {
    // Whatever order a machine gives the vertices, the centre is rounded alike.
    let mut cell = *cell;
    cell.as_mut().sort_unstable();
    let centre = circumcentre(&work.corners(&cell)[..P::Cell::LEN]);
    let domain = work.domain;
    let label = match centre.norm2().is_finite().then(|| domain.sides.locate(domain.points(), centre)) {
        Some(Some(Location::Component(c))) if domain.components[c as usize].inside => c,
        _ => Labels::OUT,
    };
    (centre, label)
}

/// The end of the ray from a circumcentre across a face of the hull.
fn beyond<P: Space>(&[a, b, c]: &[P; 3], apex: P, from: P, diagonal: f64) -> P {
    let normal = P::hull_normal(&[b - a, c - a]);
    let outwards = if normal.dot(apex - a) > 0.0 { normal * -1.0 } else { normal };
    from + outwards * (2.0 * diagonal / normal.norm2().sqrt())
}
