//! Volumes and centroids of the cells of power diagrams, and of Voronoi diagrams in periodic boxes.
//!
//! **Statement.** The power cell of a site with the position `x` and the weight `w` holds the places `y` with the least
//! `|y - x|^2 - w`. It is bounded by the bisectors to the sites that an edge of the regular triangulation joins to it: with `d = x_j - x`, the
//! places with `d . (y - x) = (|d|^2 + w - w_j) / 2`. In a periodic box, a neighbour is an image of a site. The bisectors to
//! the images of the site itself lie half a length away, so its cell lies in a box of the lengths around it.
//!
//! **Method.** The box of each site is cut by all its bisectors (`clip`). So the volumes add up to that of the box.
//!
//! **Source.** Aurenhammer, "Power diagrams: properties, algorithms and applications" (1987).
//!
//! **Work.** O(k^2) for each site with k neighbours. Depth: that of a block of sites.
//!
//! **Rounding.** All values are rounded, after a scaling by a power of two that brings the box to the size of 1. The vector to an image
//! of a site is rounded once, however far sites lie from the periodic box.

use std::borrow::Cow;

use glam::DVec3;
use septet_core::Outcome;
use septet_core::result::periodic::PeriodicCells;
use septet_core::spec::Periodic;
use septet_geometry::point::Point;
use septet_geometry::range::scale;
use septet_geometry::site::Weighted;

use crate::clip;
use crate::dimension::Dimension;
use crate::double;
use crate::error::QueryError;
use crate::loops;

/// The part of space that the cells share.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Region<'a, P> {
    /// The periodic box of the run, if it has one.
    periodic: Option<&'a Periodic>,
    /// The lower and the upper corner of a box. Along a periodic axis, its ends are not used.
    corners: Option<(P, P)>,
}

impl<'a, P: Dimension> Region<'a, P> {
    /// The box between two corners.
    pub fn of_box(low: P, high: P) -> Self {
        Region { periodic: None, corners: Some((low, high)) }
    }

    /// A box that is periodic along all axes.
    pub fn of_periods(periodic: &'a Periodic) -> Self {
        Region { periodic: Some(periodic), corners: None }
    }

    /// A box with these corners along the axes that are not periodic.
    #[must_use]
    pub fn between(self, low: P, high: P) -> Self {
        Region { corners: Some((low, high)), ..self }
    }

    /// Returns the extent along each axis.
    fn axes(&self) -> Result<Vec<Axis>, QueryError> {
        let one = |axis: usize| {
            let length = self.periodic.and_then(|periodic| periodic.lengths.get(axis).copied().flatten());
            if let Some(length) = length {
                return Ok(Axis { period: Some(length), low: 0.0, high: length });
            }
            let ends = self.corners.map(|(low, high)| (low.coord(axis), high.coord(axis)));
            let ends = ends.filter(|(low, high)| low < high && (high - low).is_finite());
            ends.map(|(low, high)| Axis { period: None, low, high }).ok_or(QueryError::EmptyBox { axis })
        };
        (0..P::DIM).map(one).collect()
    }
}

/// The extent of a region along an axis.
#[derive(Clone, Copy)]
struct Axis {
    /// The length of the period, if there is one.
    period: Option<f64>,
    low: f64,
    high: f64,
}

/// Returns the area or volume of the power cell of each site in a region, and 0 for a site that is not a vertex. `run` is the
/// triangulation of `sites`. Sites of equal weights have the volumes of their Voronoi cells.
///
/// # Errors
/// Fails if the sites are not those of the run, if the run has another box or several processes, if the sites do not span
/// the space, if the region is empty or open along an axis, or if a vertex lies outside of it.
pub fn power_volumes<P: Dimension>(
    sites: &[Weighted<P>],
    run: &Outcome,
    region: Region<'_, P>,
) -> Result<Vec<f64>, QueryError> {
    let diagram = Diagram::checked(sites, run, region)?;
    Ok(loops::map(sites.len(), |site| diagram.volume(site)))
}

/// Returns the centroid of the power cell of each site in a region, and NaN for a site that is not a vertex or has an empty cell. In a
/// periodic box, a cell lies around its site, and not around an image.
///
/// # Errors
/// As [`power_volumes`].
pub fn power_centroids<P: Dimension>(
    sites: &[Weighted<P>],
    run: &Outcome,
    region: Region<'_, P>,
) -> Result<Vec<P>, QueryError> {
    let diagram = Diagram::checked(sites, run, region)?;
    Ok(loops::map(sites.len(), |site| diagram.centroid(site)))
}

/// A convex cell.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Polytope<P> {
    /// The corners: in the plane counter-clockwise, in space each once.
    pub corners: Vec<P>,
    /// In space, the corners of each face, counter-clockwise from outside.
    pub faces: Vec<Vec<u32>>,
}

/// Returns the power cell of each site in a region, without corners for a site that is not a vertex. In a periodic box, a cell lies
/// around its site, and not around an image.
///
/// # Errors
/// As [`power_volumes`].
pub fn power_cells<P: Dimension>(
    sites: &[Weighted<P>],
    run: &Outcome,
    region: Region<'_, P>,
) -> Result<Vec<Polytope<P>>, QueryError> {
    let diagram = Diagram::checked(sites, run, region)?;
    Ok(loops::map(sites.len(), |site| diagram.cell(site)))
}

/// Checks that a run has a power diagram of `sites` in a region.
fn check_run<P: Dimension>(
    sites: &[Weighted<P>],
    run: &Outcome,
    region: Region<'_, P>,
) -> Result<(), QueryError> {
    if !run.is_whole() || run.ending().is_none() || run.kept.periodic.is_some() != region.periodic.is_some() {
        return Err(QueryError::OtherRun);
    }
    if run.space != P::DIM || run.points.input != sites.len() as u64 {
        return Err(QueryError::OtherPoints { given: sites.len(), run: run.points.input });
    }
    if run.cell_count() == 0 {
        return Err(QueryError::Flat { dimension: run.dimension });
    }
    Ok(())
}

/// A triangulation with the cells at each site, scaled.
struct Diagram<'a, P: Dimension> {
    sites: &'a [Weighted<P>],
    /// The scale is `2^exponent`.
    exponent: i32,
    axes: Vec<Axis>,
    /// `DIM + 1` sites for each cell.
    rows: Cow<'a, [u64]>,
    /// `DIM` numbers of periods for each entry of `rows`; empty without periods.
    offsets: Vec<i32>,
    /// The first entry of `corners` of each site, and the end of the last.
    starts: Vec<usize>,
    /// The positions in `rows` of each site.
    corners: Vec<usize>,
}

impl<'a, P: Dimension> Diagram<'a, P> {
    /// Checks the run and the region, and collects the cells at each site.
    fn checked(
        sites: &'a [Weighted<P>],
        run: &'a Outcome,
        region: Region<'_, P>,
    ) -> Result<Self, QueryError> {
        check_run(sites, run, region)?;
        let diagram = Self::of(sites, run, &region.axes()?);
        diagram.check()?;
        Ok(diagram)
    }

    fn of(sites: &'a [Weighted<P>], run: &'a Outcome, axes: &[Axis]) -> Self {
        // A run in a periodic box makes its rows each time, so that it does not keep them.
        let periodic = run.kept.periodic.as_ref();
        let rows = periodic.map_or_else(|| Cow::Borrowed(run.cells()), |part| Cow::Owned(part.rows()));
        let mut starts = vec![0; sites.len() + 1];
        for &site in rows.iter() {
            starts[site as usize + 1] += 1;
        }
        for site in 0..sites.len() {
            starts[site + 1] += starts[site];
        }
        let (mut next, mut corners) = (starts.clone(), vec![0; rows.len()]);
        for (at, &site) in rows.iter().enumerate() {
            corners[next[site as usize]] = at;
            next[site as usize] += 1;
        }
        let largest = axes.iter().map(|axis| axis.high - axis.low).fold(0.0, f64::max);
        let exponent = exponent_of(largest);
        let scaled = |axis: &Axis| {
            let [low, high] = [axis.low, axis.high].map(|x| times(x, exponent));
            Axis { period: axis.period.map(|length| times(length, exponent)), low, high }
        };
        let offsets = periodic.map(PeriodicCells::offsets).unwrap_or_default();
        Diagram { sites, exponent, axes: axes.iter().map(scaled).collect(), rows, offsets, starts, corners }
    }

    /// Checks that all vertices lie in the region.
    fn check(&self) -> Result<(), QueryError> {
        let is_outside = |&site: &usize| {
            let place = self.place(site);
            self.is_vertex(site)
                && self.axes.iter().enumerate().any(|(i, axis)| {
                    axis.period.is_none() && !(axis.low..=axis.high).contains(&place.coord(i))
                })
        };
        let outside = (0..self.sites.len()).find(is_outside);
        outside.map_or(Ok(()), |index| Err(QueryError::OutsideBox { index }))
    }

    /// Returns the scaled position of a site.
    fn place(&self, site: usize) -> P {
        scale(self.sites[site].position(), self.exponent)
    }

    /// Returns the scaled weight of a site.
    fn weight(&self, site: usize) -> f64 {
        times(times(self.sites[site].weight(), self.exponent), self.exponent)
    }

    /// Returns the volume of the cell of a site, in the units of the sites.
    fn volume(&self, site: usize) -> f64 {
        if !self.is_vertex(site) {
            return 0.0;
        }
        let [low, high] = self.around(site);
        let volume = clip::measure(low, high, &self.bisectors(site)).volume.max(0.0);
        (0..P::DIM).fold(volume, |volume, _| times(volume, -self.exponent))
    }

    /// Returns the centroid of the cell of a site, in the units of the sites.
    fn centroid(&self, site: usize) -> P {
        let mut centroid = P::splat(f64::NAN);
        if self.is_vertex(site) {
            let [low, high] = self.around(site);
            let measures = clip::measure(low, high, &self.bisectors(site));
            for i in 0..P::DIM {
                let place = self.place(site).coord(i) + measures.moment[i] / measures.volume;
                centroid.set_coord(i, times(place, -self.exponent));
            }
        }
        centroid
    }

    /// Returns the cell of a site, in the units of the sites.
    fn cell(&self, site: usize) -> Polytope<P> {
        if !self.is_vertex(site) {
            return Polytope { corners: Vec::new(), faces: Vec::new() };
        }
        let [low, high] = self.around(site);
        let shape = clip::shape(low, high, &self.bisectors(site));
        let place = |corner: &DVec3| {
            let mut place = self.place(site);
            for i in 0..P::DIM {
                place.set_coord(i, times(place.coord(i) + corner[i], -self.exponent));
            }
            place
        };
        Polytope { corners: shape.corners.iter().map(place).collect(), faces: shape.faces }
    }

    /// Whether a site is a vertex of the triangulation.
    fn is_vertex(&self, site: usize) -> bool {
        self.starts[site] < self.starts[site + 1]
    }

    /// Returns the corners of the box in which the cell of a site lies, relative to the site.
    fn around(&self, site: usize) -> [P; 2] {
        let (mut low, mut high, place) = (P::default(), P::default(), self.place(site));
        for (i, axis) in self.axes.iter().enumerate() {
            let half = axis.period.map(|length| length / 2.0);
            low.set_coord(i, half.map_or(axis.low - place.coord(i), |half| -half));
            high.set_coord(i, half.unwrap_or(axis.high - place.coord(i)));
        }
        [low, high]
    }

    /// Returns the bisectors between a site and its neighbours: normals and distances, near ones first.
    fn bisectors(&self, site: usize) -> Vec<(P, f64)> {
        let (corners, own) = (P::DIM + 1, self.place(site));
        let mut around: Vec<(u64, [i32; 3])> = Vec::new();
        for &at in &self.corners[self.starts[site]..self.starts[site + 1]] {
            let first = at - at % corners;
            let others = (first..first + corners).filter(|&other| other != at);
            around.extend(others.map(|other| (self.rows[other], self.steps(at, other))));
        }
        around.sort_unstable();
        around.dedup();
        let weight = self.weight(site);
        let bisector = |&(other, steps): &(u64, [i32; 3])| {
            let mut along = self.place(other as usize);
            for (i, axis) in self.axes.iter().enumerate() {
                let shift = (steps[i], axis.period.unwrap_or(0.0));
                along.set_coord(i, double::difference(own.coord(i), along.coord(i), shift));
            }
            let length = along.norm2().sqrt();
            (along / length, length / 2.0 + (weight - self.weight(other as usize)) / (2.0 * length))
        };
        let mut bisectors: Vec<(P, f64)> = around.iter().map(bisector).collect();
        bisectors.sort_by(|a, b| a.1.total_cmp(&b.1));
        bisectors
    }

    /// Returns the numbers of periods from one corner of a cell to another.
    fn steps(&self, from: usize, to: usize) -> [i32; 3] {
        let at = |corner: usize, axis: usize| self.offsets.get(corner * P::DIM + axis).copied().unwrap_or(0);
        std::array::from_fn(|axis| if axis < P::DIM { at(to, axis) - at(from, axis) } else { 0 })
    }
}

/// Returns the exponent of the power of two that brings a finite positive number to the size of 1.
pub(crate) fn exponent_of(x: f64) -> i32 {
    1023 - ((x.to_bits() >> 52) as i32 & 0x7ff)
}

/// Returns `x` times `2^exponent`, which may be beyond the range of a factor.
pub(crate) fn times(x: f64, exponent: i32) -> f64 {
    let half = exponent / 2;
    x * 2f64.powi(half) * 2f64.powi(exponent - half)
}
