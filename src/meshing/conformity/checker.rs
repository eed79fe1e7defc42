//! The state that the parts of a check share.

use septet_geometry::predicates::{Sign, orientation};
use septet_geometry::range::scale;

use super::defect::MeshDefect;
use super::findings::Conformity;
use crate::domain::Domain;
use crate::executor::Executor;
use crate::mesh::Mesh;
use crate::quality::angles::measure;
use crate::space::Space;
use crate::sum::Sum;

/// The tolerance for sums of areas and volumes, relative to the whole.
pub const SUMS: f64 = 1e-9;

/// The tolerance for the distance of a point from its carrier, relative to the largest coordinate.
pub const OFF: f64 = 1e-12;

/// The state of a check.
pub(super) struct Checker<'a, P: Space> {
    pub(super) domain: &'a Domain<P>,
    pub(super) mesh: &'a Mesh<P>,
    /// The points of the mesh in the scaled coordinates of the domain.
    pub(super) points: Vec<P>,
    pub(super) found: Conformity,
}

impl<P: Space> Checker<'_, P> {
    pub(super) fn report(&mut self, defect: MeshDefect) {
        self.found.defects.push(defect);
    }

    fn corners(&self, cell: &P::Cell) -> [P; 4] {
        let mut corners = [P::default(); 4];
        for (corner, &v) in corners.iter_mut().zip(cell.as_ref()) {
            *corner = self.points[v as usize];
        }
        corners
    }

    /// Returns the largest distance by which the grid of translated coordinates moves a point: 0 if none is
    /// translated.
    pub(super) fn step(&self) -> f64 {
        self.domain.simplices.frame.grid()
    }

    /// Returns the sum of the measures of all walls.
    fn walls(&self) -> f64 {
        (0..self.domain.walls().len() as u32).map(|w| self.wall_extent(w)).sum()
    }

    /// Converts a measure of dimension `d` to the unit of the file.
    pub(super) fn unscaled(&self, mut x: f64, d: usize) -> f64 {
        for _ in 0..d {
            x = scale(P::splat(x), -self.domain.simplices.frame.exponent).coord(0);
        }
        x
    }

    pub(super) fn cells(&mut self, executor: &impl Executor) {
        let signs = executor.map(&self.mesh.cells, |cell| orientation(&self.corners(cell)[..=P::DIM]));
        for ((i, cell), sign) in self.mesh.cells.iter().enumerate().zip(signs) {
            let row = cell.as_ref();
            let ordered = (0..P::DIM - 1).all(|k| row[k + 1..].iter().all(|&v| row[k] < v));
            let behind = i == 0 || self.mesh.cells[i - 1] < *cell;
            let cell = i as u32;
            if sign != Sign::Positive {
                self.report(MeshDefect::Orientation { cell, sign });
            }
            if !ordered || !behind {
                self.report(MeshDefect::Order { cell });
            }
        }
    }

    pub(super) fn used(&mut self) {
        let mut used = vec![false; self.points.len()];
        for cell in &self.mesh.cells {
            cell.as_ref().iter().for_each(|&v| used[v as usize] = true);
        }
        for (i, &carrier) in self.mesh.carriers.iter().enumerate() {
            if !used[i] {
                self.report(MeshDefect::Unused { point: i as u32, what: "cell", carrier });
            }
        }
    }

    pub(super) fn volumes(&mut self, exact: bool) {
        let mut sums = vec![Sum::default(); self.domain.components.len()];
        for (cell, &region) in self.mesh.cells.iter().zip(&self.mesh.regions) {
            sums[region as usize].add(measure(&self.corners(cell)));
        }
        if !exact {
            self.has_cells(&sums);
        }
        let mut totals = [Sum::default(); 2];
        let slack = self.step() * self.walls();
        for (component, (sum, of)) in sums.into_iter().zip(&self.domain.components).enumerate() {
            if !of.inside {
                continue;
            }
            totals[0].add(of.measure);
            totals[1].add(sum.value());
            if exact && off(of.measure, sum.value(), of.measure, slack) {
                let [expected, found] = [of.measure, sum.value()].map(|x| self.unscaled(x, P::DIM));
                self.report(MeshDefect::Volume { component: component as u32, expected, found });
            }
        }
        self.found.measure = totals.map(|t| self.unscaled(t.value(), P::DIM));
    }
}

/// Returns `true` if the difference of two sums exceeds the tolerance. `slack` is the part of it that is due to the
/// grid of translated coordinates.
pub(super) fn off(expected: f64, found: f64, whole: f64, slack: f64) -> bool {
    let difference = (expected - found).abs();
    difference > SUMS * whole.abs() + slack || difference.is_nan()
}
