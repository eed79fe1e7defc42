//! The quality of a mesh.
//!
//! **Statement.** The following is measured:
//! - for every cell: guaranteed bounds of its radius-edge ratio ([`ratio`]), its angles and its volume;
//! - for every edge: its length divided by the smaller size at its ends, and the slope of the size function along it;
//! - for every point: its size divided by the local feature size;
//! - for the whole mesh: the number of points divided by the integral of `dx / f^d`.
//!
//! The promise `R/l <= B` depends on the location of the circumcentre ([`CentrePlace`]), so maxima and violations are
//! recorded per location. The comparison of a ratio with its bound is exact. All other values are rounded, and no
//! decision depends on them.
//!
//! **Work and depth.** O(1) per cell, a sort of the edges, and calls to the caller's functions. Parallel over cells and
//! points, except for the sort and the sums.

pub mod angles;
pub mod balls;
pub mod estimate;
pub mod histogram;
pub mod promise;
pub mod ratio;
pub mod reasons;
pub mod shapes;
pub mod zones;

use std::collections::BTreeMap;
use std::ops::Deref;

use septet_geometry::measure::circumcentre;
use septet_geometry::point::Point;
use septet_geometry::range::scale;

use crate::domain::{Domain, Feature};
use crate::executor::{Executor, Sequential};
use crate::mesh::{Carrier, Mesh};
use crate::space::Space;
use crate::sum::Sum;
use histogram::Histogram;
use ratio::Bracket;
use shapes::{Shape, Shapes};

/// The location of the circumcentre of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum CentrePlace {
    /// In the domain, but in no ball of a feature ([`balls`]). For a remeshed surface, outside its [`zones`].
    Free,
    /// In the domain, in a ball of this feature. For a remeshed surface, in its zone.
    Near(Feature),
    /// In the domain, above a subfacet of this facet that is larger than the size at its centre.
    Above(Feature),
    /// Outside the domain, with the nearest feature. `None` for flat cells.
    Outside(Option<Feature>),
}

impl CentrePlace {
    /// Returns the feature of the location.
    pub fn feature(self) -> Option<Feature> {
        match self {
            CentrePlace::Free => None,
            CentrePlace::Near(feature) | CentrePlace::Above(feature) => Some(feature),
            CentrePlace::Outside(feature) => feature,
        }
    }
}

/// The functions and bounds against which quality is measured. Functions take points and return lengths in the scaled
/// coordinates of the domain.
pub struct Measure<'a, P> {
    /// Returns the location of a circumcentre, given its position and the circumradius.
    pub place: &'a (dyn Fn(P, f64) -> CentrePlace + Sync),
    /// The local feature size, if f is to be compared with it.
    pub local_size: Option<&'a (dyn Fn(P) -> f64 + Sync)>,
    /// The promised radius-edge bounds for free cells, near cells, and cells above large subfacets. `None` if nothing
    /// is promised.
    pub promised: [Option<f64>; 3],
    /// The number of worst cells kept in each list.
    pub worst: usize,
}

/// One of the worst cells.
#[derive(Clone, Debug, PartialEq)]
pub struct WorstCell<P> {
    /// The index of the cell.
    pub cell: u32,
    /// The radius-edge ratio.
    pub ratio: Bracket,
    /// The smallest and largest angle in degrees.
    pub angles: [f64; 2],
    /// The location of the circumcentre.
    pub place: CentrePlace,
    /// The mean of its points, in the unit of the file.
    pub at: P,
    /// Its points and their carriers.
    pub vertices: Vec<(u32, Carrier)>,
}

/// The radius-edge ratios of the cells with one kind of location of the circumcentre.
#[derive(Clone, Debug, PartialEq)]
pub struct RadiusEdge<P> {
    /// The number of cells.
    pub cells: u64,
    /// Bounds of the largest ratio.
    pub most: Bracket,
    /// The promised bound.
    pub promised: Option<f64>,
    /// The exact number of cells above the bound. It is 0 if nothing is promised.
    pub over: u64,
    /// The cells with the largest ratios.
    pub worst: Vec<WorstCell<P>>,
}

/// The cells near one feature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearFeature {
    /// The feature.
    pub feature: Feature,
    /// The number of cells whose circumcentres are near the feature, or outside the domain with this feature as the
    /// nearest one.
    pub cells: u64,
    /// The number of these cells above their bound.
    pub over: u64,
    /// Bounds of the largest ratio.
    pub most: Bracket,
    /// The cell with the largest ratio.
    pub worst: u32,
    /// The smallest angle of these cells, in degrees.
    pub least_angle: f64,
}

/// The edge with the largest slope of f.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Steepest {
    /// `|f(p) - f(q)| / |p - q|`.
    pub slope: f64,
    /// The points of the edge.
    pub edge: [u32; 2],
}

/// Limits for the smallest angle of a sliver, in degrees.
pub const SLIVERS: [f64; 3] = [5.0, 10.0, 14.0];

/// The radius-edge ratio below which a cell with small angles is a sliver and not just a bad cell.
pub const SLIVER_RATIO: f64 = 2.0;

/// The measured quality of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Quality<P> {
    /// The shapes of the cells. They are also fields of the quality. Ratios are upper bounds. The smallest and the
    /// largest measure are in the unit of the file, and their sum is in scaled coordinates.
    pub shapes: Shapes,
    /// The cells by location: free, near, above large subfacets, outside.
    pub places: [RadiusEdge<P>; 4],
    /// The cells by the feature of their location, in descending order of the largest ratio.
    pub features: Vec<NearFeature>,
    /// The cells with the smallest angles.
    pub thinnest: Vec<WorstCell<P>>,
    /// The total measure of all cells.
    pub volume: f64,
    /// The length of every edge, divided by the smaller size at its ends.
    pub lengths: Histogram,
    /// f divided by the local feature size, at every point, if requested.
    pub grading: Option<Histogram>,
    /// The sum over cells of the volume times the mean of `f^-d`.
    pub integral: f64,
    /// The number of points.
    pub points: u64,
    /// The steepest edge. Its slope is a lower bound of the Lipschitz constant of f.
    pub steepest: Steepest,
}

impl<P> Deref for Quality<P> {
    type Target = Shapes;

    fn deref(&self) -> &Shapes {
        &self.shapes
    }
}

/// Measures a mesh. Its arrays must be consistent, and its sizes must be positive.
pub fn quality<P: Space>(domain: &Domain<P>, mesh: &Mesh<P>, measure: &Measure<'_, P>) -> Quality<P> {
    quality_on(domain, mesh, measure, &Sequential)
}

/// Measures a mesh as [`quality`] does. The executor maps over cells and points, so the result does not depend on it.
pub fn quality_on<P: Space>(
    domain: &Domain<P>,
    mesh: &Mesh<P>,
    measure: &Measure<'_, P>,
    executor: &impl Executor,
) -> Quality<P> {
    let exponent = domain.simplices.frame.exponent;
    let length = |x: f64| scale(P::splat(x), exponent).coord(0);
    let mut assessor = Assessor {
        mesh,
        measure,
        points: mesh.points.iter().map(|&p| domain.simplices.frame.inward(p)).collect(),
        sizes: mesh.sizes.iter().map(|&f| length(f)).collect(),
        features: BTreeMap::new(),
        out: empty(mesh.points.len() as u64, measure),
    };
    assessor.cells(exponent, executor);
    assessor.edges();
    if let Some(local_size) = measure.local_size {
        let mut grading = Histogram::new(0.0, 1.0, 20);
        let local = executor.map(&assessor.points, |&p| local_size(p));
        assessor.sizes.iter().zip(local).for_each(|(f, local)| grading.add(f / local));
        assessor.out.grading = Some(grading);
    }
    let mut features: Vec<NearFeature> = assessor.features.into_values().collect();
    features.sort_by(|a, b| b.most.upper.total_cmp(&a.most.upper).then(a.feature.cmp(&b.feature)));
    Quality { features, ..assessor.out }
}

fn empty<P: Point>(points: u64, measure: &Measure<'_, P>) -> Quality<P> {
    let [free, near, above] = measure.promised;
    let place = |promised| RadiusEdge {
        cells: 0,
        most: Bracket { lower: 0.0, upper: 0.0 },
        promised,
        over: 0,
        worst: Vec::new(),
    };
    Quality {
        shapes: Shapes::default(),
        places: [place(free), place(near), place(above), place(None)],
        features: Vec::new(),
        thinnest: Vec::new(),
        volume: 0.0,
        lengths: Histogram::new(0.0, 4.0, 80),
        grading: None,
        integral: 0.0,
        points,
        steepest: Steepest::default(),
    }
}

/// The number of cells that are measured at a time.
const BATCH: usize = 1 << 16;

/// The values of one cell.
struct Facts {
    ratio: Bracket,
    shape: Shape,
    place: CentrePlace,
    /// The position of the place in [`Quality::places`].
    class: usize,
    over: bool,
}

struct Assessor<'a, P: Space> {
    mesh: &'a Mesh<P>,
    measure: &'a Measure<'a, P>,
    /// Scaled coordinates.
    points: Vec<P>,
    sizes: Vec<f64>,
    features: BTreeMap<Feature, NearFeature>,
    out: Quality<P>,
}

impl<P: Space> Assessor<'_, P> {
    fn cells(&mut self, exponent: i32, executor: &impl Executor) {
        let mut integral = Sum::default();
        let rows: Vec<u32> = (0..self.mesh.cells.len() as u32).collect();
        for rows in rows.chunks(BATCH) {
            for (&row, facts) in rows.iter().zip(executor.map(rows, |&row| self.facts(row))) {
                let cell = self.mesh.cells[row as usize];
                let density = cell.as_ref().iter().map(|&v| self.sizes[v as usize].powi(-(P::DIM as i32)));
                integral.add(facts.shape.volume * density.sum::<f64>() / (P::DIM + 1) as f64);
                self.cell(row, &facts);
            }
        }
        let unscaled = |x: f64| (0..P::DIM).fold(x, |x, _| scale(P::splat(x), -exponent).coord(0));
        let volume = self.out.shapes.volume.value();
        self.out.volume = unscaled(volume);
        self.out.shapes.volumes = self.out.shapes.volumes.map(unscaled);
        self.out.integral = integral.value();
    }

    /// Measures a cell by itself.
    fn facts(&self, row: u32) -> Facts {
        let mut corners = [P::default(); 4];
        for (corner, &v) in corners.iter_mut().zip(self.mesh.cells[row as usize].as_ref()) {
            *corner = self.points[v as usize];
        }
        let corners = &corners[..=P::DIM];
        let ratio = ratio::ratio(corners);
        let volume = angles::measure(corners);
        let shape = Shape { ratio: ratio.upper, angles: angles::angles(corners), volume };
        let centre = circumcentre(corners);
        let flat = !(0..P::DIM).all(|i| centre.coord(i).is_finite());
        let radius = (centre - corners[0]).norm2().sqrt();
        let place = if flat { CentrePlace::Outside(None) } else { (self.measure.place)(centre, radius) };
        let class = match place {
            CentrePlace::Free => 0,
            CentrePlace::Near(_) => 1,
            CentrePlace::Above(_) => 2,
            CentrePlace::Outside(_) => 3,
        };
        let over = self.out.places[class].promised.is_some_and(|bound| !ratio::at_most(corners, bound));
        Facts { ratio, shape, place, class, over }
    }

    /// Adds the values of a cell.
    fn cell(&mut self, row: u32, facts: &Facts) {
        let &Facts { ratio, ref shape, place, class, over } = facts;
        let [least, largest] = shape.range();
        self.out.shapes.add(shape);
        let kind = &mut self.out.places[class];
        kind.cells += 1;
        kind.over += u64::from(over);
        kind.most = larger(kind.most, ratio);
        if let Some(feature) = place.feature() {
            self.near(feature, row, ratio, least, over);
        }
        let keep = self.measure.worst;
        let by_ratio = |c: &WorstCell<P>| -c.ratio.upper;
        let by_angle = |c: &WorstCell<P>| c.angles[0];
        let angles = [least, largest];
        if enters(&self.out.places[class].worst, keep, -ratio.upper, by_ratio) {
            let worst = self.describe(row, ratio, angles, place);
            insert(&mut self.out.places[class].worst, keep, worst, by_ratio);
        }
        if enters(&self.out.thinnest, keep, least, by_angle) {
            let worst = self.describe(row, ratio, angles, place);
            insert(&mut self.out.thinnest, keep, worst, by_angle);
        }
    }

    fn near(&mut self, feature: Feature, cell: u32, ratio: Bracket, least_angle: f64, over: bool) {
        let first = NearFeature { feature, cells: 0, over: 0, most: ratio, worst: cell, least_angle };
        let line = self.features.entry(feature).or_insert(first);
        line.cells += 1;
        line.over += u64::from(over);
        if ratio.upper > line.most.upper {
            line.worst = cell;
        }
        line.most = larger(line.most, ratio);
        line.least_angle = line.least_angle.min(least_angle);
    }

    fn describe(&self, cell: u32, ratio: Bracket, angles: [f64; 2], place: CentrePlace) -> WorstCell<P> {
        let row = self.mesh.cells[cell as usize].as_ref();
        let sum =
            row.iter().fold(P::splat(0.0), |sum, &v| sum + self.mesh.points[v as usize] / row.len() as f64);
        let vertices = row.iter().map(|&v| (v, self.mesh.carriers[v as usize])).collect();
        WorstCell { cell, ratio, angles, place, at: sum, vertices }
    }

    fn edges(&mut self) {
        for edge in self.mesh.cell_edges() {
            let [f, g] = edge.map(|v| self.sizes[v as usize]);
            let [p, q] = edge.map(|v| self.points[v as usize]);
            let length = (p - q).norm2().sqrt();
            self.out.lengths.add(length / f.min(g));
            let slope = (f - g).abs() / length;
            if slope > self.out.steepest.slope {
                self.out.steepest = Steepest { slope, edge };
            }
        }
    }
}

fn larger(a: Bracket, b: Bracket) -> Bracket {
    Bracket { lower: a.lower.max(b.lower), upper: a.upper.max(b.upper) }
}

/// Returns `true` if a cell with this key would be among the first `keep` cells.
fn enters<P>(list: &[WorstCell<P>], keep: usize, key: f64, of: impl Fn(&WorstCell<P>) -> f64) -> bool {
    list.len() < keep || list.last().is_some_and(|last| key < of(last))
}

/// Inserts a cell after cells with the same key, and truncates the list.
fn insert<P>(
    list: &mut Vec<WorstCell<P>>,
    keep: usize,
    new: WorstCell<P>,
    of: impl Fn(&WorstCell<P>) -> f64,
) {
    let at = list.partition_point(|c| of(c) <= of(&new));
    list.insert(at, new);
    list.truncate(keep);
}
