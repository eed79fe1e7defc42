//! From the content of a file to an input whose check is exact.
//!
//! **Statement.** Files round coordinates, repeat points and list the parts of a domain one by one. Each step removes one
//! kind of these deviations and says so ([`Change`]). The numbering of points stays. Facets keep the number that they
//! have in the file, also if several stand for one. The steps run in this order:
//!
//! | step | runs | file |
//! | --- | --- | --- |
//! | points within a distance become one | with a weld distance | `weld` |
//! | elements without length or area are dropped | on request | `degenerate` |
//! | facets with equal corners are dropped | on request | `double` |
//! | edges are divided at the points on them | on request | `junctions` |
//! | small holes are closed | on request | `holes` |
//! | solids become regions or markers | always | `solids` |
//! | facets that are planar within the digits become triangles | always | `flat` |
//!
//! The exact check ([`crate::check()`]) judges the result. It knows no tolerance, and no step can make it accept an input
//! whose elements intersect. It identifies points with equal coordinates. Parts that an odd number of facets separates
//! from the outside are inside. So it accepts equal points, and edges with four facets.
//!
//! **Work and depth.** `O(m log m)`, sequential.

mod change;
mod degenerate;
mod double;
mod flat;
mod holes;
mod junctions;
mod solids;
mod weld;

use glam::{DVec2, DVec3};
use septet_geometry::point::lex_cmp;
use septet_geometry::range::{scale, scale_exponent};

use crate::defect::{At, Defect, Element};
use crate::digits::Digits;
use crate::facet::Triangulate;
use crate::input::{DomainKind, Input, InputFacet};
use crate::space::{Space, ascending};

pub use change::{Change, ChangeInFile, Dropped};
pub use holes::{MOST_AREA, MOST_EDGES};
pub use solids::Solids;

/// How far an input may deviate from an exact domain.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Tolerance {
    /// Whether equal points, facets that are not exactly planar, and edges or vertices that are not manifold are defects.
    /// Then nothing is welded or repaired.
    pub strict: bool,
    /// The distance within which points are joined, in the unit of the file.
    pub weld: Option<f64>,
    /// Whether T-junctions, double and degenerate elements, small holes and bent polygons of surfaces are repaired.
    pub repair: bool,
}

impl Tolerance {
    /// Returns the tolerance after a change.
    #[must_use]
    pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
        change(&mut self);
        self
    }
}

/// An input that is ready for the exact check.
#[derive(Clone, Debug, PartialEq)]
pub struct Prepared<P> {
    /// The input.
    pub input: Input<P>,
    /// The number in the file of each facet. New facets follow those of the file.
    pub origin: Vec<u32>,
    /// The solids of the facets, if each solid is a region.
    pub solids: Option<Solids>,
    /// The changes.
    pub changes: Vec<Change>,
}

impl<P> Prepared<P> {
    /// Replaces the numbers of facets in a defect by those in the file.
    pub(crate) fn in_file(&self, mut defect: Defect) -> Defect {
        let id = |f: &mut u32| *f = self.origin.get(*f as usize).copied().unwrap_or(*f);
        let name = |element: &mut Element| {
            if let Element::Facet(f) = element {
                id(f);
            }
        };
        match &mut defect {
            Defect::NoSuchPoint { element, .. }
            | Defect::Degenerate { element, .. }
            | Defect::Dangling { element, .. }
            | Defect::Misplaced { element, .. }
            | Defect::TooThin { element, .. } => name(element),
            Defect::NotPlanar { facet, .. }
            | Defect::FacetHole { facet, .. }
            | Defect::OpenEdge { facet, .. } => id(facet),
            Defect::Doubled { elements, .. } | Defect::Intersect { elements, .. } => {
                elements.iter_mut().for_each(name);
            }
            Defect::NonManifoldEdge { facets, .. } => facets.iter_mut().for_each(id),
            Defect::Empty
            | Defect::Range(_)
            | Defect::Duplicate { .. }
            | Defect::NonManifoldVertex { .. }
            | Defect::Unclosed
            | Defect::SharedComponent { .. } => {}
        }
        defect
    }
}

/// The steps that need the dimension.
pub trait Repair: Triangulate {
    /// Runs the steps on facets.
    #[doc(hidden)]
    fn facets(mending: &mut Mending<Self>, tolerance: &Tolerance, exponent: i32);
}

impl Repair for DVec2 {
    fn facets(_: &mut Mending<Self>, _: &Tolerance, _: i32) {}
}

impl Repair for DVec3 {
    fn facets(mending: &mut Mending<Self>, tolerance: &Tolerance, exponent: i32) {
        let scaled: Vec<DVec3> = mending.input.points.iter().map(|&p| scale(p, exponent)).collect();
        let limit = Digits::of(&mending.input.points).rounding();
        if tolerance.repair {
            double::double(mending);
            if mending.input.kind == DomainKind::Surface {
                junctions::junctions(mending, &scaled, limit.max(tolerance.weld.unwrap_or(0.0)));
                holes::holes(mending);
            }
        }
        solids::solids(mending);
        flat::flatten(mending, (&scaled, exponent), limit, tolerance.repair);
    }
}

/// Prepares an input for the exact check.
pub fn prepare<P: Repair>(input: &Input<P>, tolerance: &Tolerance) -> Prepared<P> {
    let mut mending = Mending::new(input);
    let all =
        [input.points.as_slice(), &input.holes, &input.regions.iter().map(|r| r.at).collect::<Vec<_>>()];
    let count = input.points.len();
    let named = input.facets.iter().flat_map(|f| f.polygons.iter().flatten().copied());
    let has_points = named.chain(input.segments.iter().flat_map(|s| s.ends)).all(|v| (v as usize) < count);
    // The check reports coordinates out of range.
    if let (Ok(exponent), true) = (scale_exponent(&all.concat()), has_points) {
        if let Some(distance) = tolerance.weld {
            weld::weld(&mut mending, distance);
        }
        if tolerance.repair {
            let scaled: Vec<P> = mending.input.points.iter().map(|&p| scale(p, exponent)).collect();
            degenerate::degenerate(&mut mending, &scaled);
        }
        P::facets(&mut mending, tolerance, exponent);
    }
    let Mending { input, origin, solids, is_by_regions, changes, .. } = mending;
    let solids = is_by_regions.then(|| Solids::new(input.solids.len() as u32, solids));
    Prepared { input, origin, solids, changes }
}

/// An input that is being changed.
#[doc(hidden)]
#[derive(Debug)]
pub struct Mending<P> {
    input: Input<P>,
    origin: Vec<u32>,
    /// The solids of each facet. Empty if there is only one.
    solids: Vec<Vec<u32>>,
    /// Whether each solid is a region.
    is_by_regions: bool,
    changes: Vec<Change>,
    /// The number of facets in the file.
    facets_of_file: u32,
}

impl<P: Space> Mending<P> {
    fn new(input: &Input<P>) -> Self {
        let facets_of_file = input.facets.len() as u32;
        let mut solids = Vec::new();
        if input.solids.len() > 1 {
            for (s, of) in input.solids.iter().enumerate() {
                solids.resize((of.end as usize).max(solids.len()), vec![s as u32]);
            }
            solids.resize(input.facets.len(), vec![0]);
        }
        let origin = (0..facets_of_file).collect();
        let (is_by_regions, changes) = (false, Vec::new());
        Mending { input: input.clone(), origin, solids, is_by_regions, changes, facets_of_file }
    }

    /// Returns the solids of a facet, or an empty list if there is only one.
    fn solids_of(&self, facet: usize) -> Vec<u32> {
        self.solids.get(facet).cloned().unwrap_or_default()
    }

    /// Returns the first of the points with the same coordinates, for each point.
    fn same(&self) -> Vec<u32> {
        let points = &self.input.points;
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        order.sort_by(|&a, &b| lex_cmp(&points[a as usize], &points[b as usize]).then(a.cmp(&b)));
        let mut same: Vec<u32> = (0..points.len() as u32).collect();
        for group in order.chunk_by(|&a, &b| points[a as usize] == points[b as usize]) {
            for &v in group {
                same[v as usize] = group[0];
            }
        }
        same
    }

    /// Returns the edges of the polygons of a facet, between the first of equal points.
    fn edges_of(&self, facet: u32, same: &[u32]) -> Vec<[u32; 2]> {
        let mut edges = Vec::new();
        for polygon in self.input.facets[facet as usize].polygons.iter().filter(|l| l.len() > 2) {
            let ids: Vec<u32> = polygon.iter().filter_map(|&v| same.get(v as usize).copied()).collect();
            let pairs = (0..ids.len()).map(|k| [ids[k], ids[(k + 1) % ids.len()]]);
            edges.extend(pairs.filter(|e| e[0] != e[1]).map(ascending));
        }
        edges
    }

    fn place(p: P) -> At {
        At((0..P::DIM).map(|i| p.coord(i)).collect())
    }

    /// Keeps some of the facets.
    fn retain(&mut self, keep: &[bool]) {
        fn kept<T>(list: &mut Vec<T>, keep: &[bool]) {
            let mut at = 0;
            list.retain(|_| {
                at += 1;
                keep[at - 1]
            });
        }
        if keep.iter().any(|k| !k) {
            kept(&mut self.input.facets, keep);
            kept(&mut self.origin, keep);
            if !self.solids.is_empty() {
                kept(&mut self.solids, keep);
            }
        }
    }

    fn push(&mut self, facet: InputFacet<P>, origin: u32, solids: Vec<u32>) {
        self.input.facets.push(facet);
        self.origin.push(origin);
        if !solids.is_empty() {
            self.solids.push(solids);
        }
    }
}

impl Mending<DVec3> {
    /// Returns the area of the facets, without regard to holes.
    fn area(&self) -> f64 {
        let points = &self.input.points;
        let of = |l: &Vec<u32>| -> f64 {
            let at = |k: usize| points[l[k % l.len()] as usize] - points[l[0] as usize];
            (0..l.len()).map(|k| at(k).cross(at(k + 1))).sum::<DVec3>().length() / 2.0
        };
        self.input.facets.iter().flat_map(|f| &f.polygons).filter(|l| l.len() > 2).map(of).sum()
    }
}
