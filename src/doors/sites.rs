//! Points with weights or in a periodic box, and the queries that have answers for them.

use septet_core::Door;
use septet_core::spec::Periodic;

use crate::failure::Failure;

/// The weights and the periodic box of points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sites {
    /// The weight of each point, which is a squared length. The triangulation is then the regular one.
    pub weights: Option<Vec<f64>>,
    /// The box in which the points lie, and which repeats.
    pub periodic: Option<Periodic>,
}

impl Sites {
    /// Whether the points have neither weights nor a periodic box.
    pub fn are_plain(&self) -> bool {
        self.weights.is_none() && self.periodic.is_none()
    }

    /// Checks that there is a weight for each point, and that weights are finite if points must be.
    ///
    /// # Errors
    /// Fails if the number of weights is wrong, and with the row of a weight that is not finite.
    pub(crate) fn check(&self, points: usize, skips_invalid: bool, door: Door) -> Result<(), Failure> {
        let Some(weights) = &self.weights else { return Ok(()) };
        if weights.len() != points {
            return Err(Failure::usage(format!(
                "{} weights for {points} points; pass one weight for each point",
                weights.len()
            )));
        }
        match weights.iter().position(|weight| !weight.is_finite()) {
            Some(index) if !skips_invalid => {
                let remedy = door.spell("correct it, or drop such points with {skip-invalid}");
                let message = format!("point {index}: weight {} is not finite; {remedy}", weights[index]);
                Err(Failure::new(septet_core::Code::Input, message).at(index as u64))
            }
            _ => Ok(()),
        }
    }
}

/// A query that not all triangulations can answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Query {
    Locate,
    Barycentric,
    Linear,
    Gradients,
    Transforms,
    Circumspheres,
    Hull,
    Edges,
    Volumes,
    PowerCells,
    Nearest,
    Natural,
    Ridges,
    Alpha,
}

impl Query {
    const ALL: [Query; 14] = [
        Query::Locate,
        Query::Barycentric,
        Query::Linear,
        Query::Gradients,
        Query::Transforms,
        Query::Circumspheres,
        Query::Hull,
        Query::Edges,
        Query::Volumes,
        Query::PowerCells,
        Query::Nearest,
        Query::Natural,
        Query::Ridges,
        Query::Alpha,
    ];

    /// Whether the query has an answer for these points.
    fn fits(self, sites: &Sites) -> bool {
        match self {
            Query::Volumes | Query::PowerCells => true,
            Query::Locate
            | Query::Barycentric
            | Query::Linear
            | Query::Gradients
            | Query::Transforms
            | Query::Circumspheres
            | Query::Hull
            | Query::Edges => sites.periodic.is_none(),
            Query::Nearest | Query::Natural | Query::Ridges | Query::Alpha => sites.are_plain(),
        }
    }

    /// Returns the spelling of a door, if it has the query.
    fn name(self, door: Door) -> Option<&'static str> {
        let (python, c) = match self {
            Query::Locate => ("find_simplex", Some("septet_locate")),
            Query::Barycentric => ("barycentric", None),
            Query::Linear => (
                "weights and interpolate with method=\"linear\"",
                Some("septet_interpolate with SEPTET_LINEAR"),
            ),
            Query::Gradients => ("gradients", None),
            Query::Transforms => ("transform", None),
            Query::Circumspheres => ("circumcenters and circumradii", None),
            Query::Hull => ("convex_hull", Some("septet_hull")),
            Query::Edges => ("edges and vertex_neighbor_vertices", None),
            Query::Volumes => ("volumes", None),
            Query::PowerCells => {
                ("volumes, centroids, vertices and regions of septet.Voronoi", Some("septet_voronoi_volumes"))
            }
            Query::Nearest => ("nearest_vertex", Some("septet_nearest")),
            Query::Natural => (
                "method=\"sibson\" and method=\"laplace\"",
                Some("septet_interpolate with SEPTET_SIBSON or SEPTET_LAPLACE"),
            ),
            Query::Ridges => ("ridge_points, ridge_vertices and ridge_areas", None),
            Query::Alpha => ("alpha_filtration and alpha_shape", Some("septet_alpha")),
        };
        if door == Door::C { c } else { Some(python) }
    }

    /// Checks that the query has an answer for these points.
    ///
    /// # Errors
    /// Fails with the queries that have one.
    pub(crate) fn check(self, sites: &Sites, door: Door) -> Result<(), Failure> {
        if self.fits(sites) {
            return Ok(());
        }
        let cause = if sites.periodic.is_some() { "in a periodic box" } else { "with weights" };
        let arrays = match (door, &sites.periodic) {
            (Door::C, Some(_)) => {
                "septet_cells_i32, septet_cells_i64, septet_neighbors_i32, septet_neighbors_i64, septet_offsets"
            }
            (Door::C, None) => {
                "septet_cells_i32, septet_cells_i64, septet_neighbors_i32, septet_neighbors_i64, septet_hidden"
            }
            (_, Some(_)) => "simplices, neighbors, offsets",
            (_, None) => "simplices, neighbors, hidden",
        };
        let has_answer = |query: &Query| query.fits(sites);
        let known = Query::ALL.into_iter().filter(has_answer).filter_map(|query| query.name(door));
        let known: Vec<&str> = std::iter::once(arrays).chain(known).collect();
        let name = self.name(door).unwrap_or("this query");
        Err(Failure::usage(format!("{name}: not available {cause}; use {}", known.join(", "))))
    }
}
