//! The size function: the distance that points of the mesh must keep from each other.
//!
//! **Statement.** Let Q be a part of the space that contains the domain. Let
//! `f*(x) = inf_{y in Q} (lfs(y) + L |x - y|)`, the largest L-Lipschitz function that is nowhere in Q above the local
//! feature size. A tree of cells gives finitely many cones. Their minimum g satisfies
//! ```text
//! (1 - loss) f*(x) <= g(x) <= f*(x) <= lfs(x),    L lfs(x) <= f*(x)
//! ```
//! for all x in Q. Q is a cube around the domain without the cells that lie outside the domain and meet no feature. The
//! small sizes in a narrow gap between two parts of a surface therefore affect only these parts. If the features are
//! not all features of the domain, Q is the whole cube. The size function is
//! `f(x) = max(least, min(user(x), regions(x), g(x)))`. It is L-Lipschitz, because all its parts are. (With a smallest
//! size, the first inequality holds if `max(least, .)` is applied to both sides.)
//!
//! *Proof.* Let m be the centre of a cell, r its radius, and y a point in it.
//! 1. *`g <= f*` if every cell is kept.* lfs is 1-Lipschitz, so the cone of the cell satisfies
//!    `a + L |x - m| = lfs(m) - (1+L) r + L |x - m| <= lfs(y) + L |x - y|`.
//! 2. *Dropped cells (see `local`).* A cell may be dropped because of the user's function or the cone at the middle of
//!    a simplex. f includes both. Otherwise, some z has `lfs(z) + L |m - z|` strictly below a. Then
//!    `lfs(z) + L |x - z|` is below `a + L |x - m|`, and the cell of z replaces it. The cell of z is not outside Q,
//!    because z lies on a feature, or m is inside the domain and z lies on the same side of all features. Values
//!    decrease strictly, so no cell recurs, and the last one is kept.
//! 3. *`(1 - loss) f* <= g`.* A kept cell has `(1+L) r <= loss lfs(m)`, so `a >= (1 - loss) lfs(m)` and its cone is at
//!    least `(1 - loss) f*(x)`. The cones at middles of simplices satisfy the same bound.
//! 4. *`L lfs <= f*`.* lfs(y) is at least `lfs(x) - |x - y|`. So `lfs(y) + L |x - y| >= L lfs(x)` as long as L is at
//!    most 1. QED.
//!
//! Cells that are not dropped are split iff `max(lfs(m), least) < k s` with `k = (1+L) sqrt(d) / (2 loss)`. For
//! `loss <= (1+L) / 3`, this gives `k >= 1.5 sqrt(d)`. If no cell is dropped, the tree is therefore balanced
//! ([`crate::octree`]), and every leaf has `lfs` between `(k - sqrt(d)/2) s` and `(2 k + 1.5 sqrt(d)) s`.
//!
//! Facets that are joined into flats ([`crate::flats`]) are one feature. Their inner segments and joints do not count,
//! but f has a cone at each joint, whose height is the length of the shortest segment there.
//!
//! If features meet at an angle, lfs does not tend to zero along them, but points on the two features can be
//! arbitrarily close. [`SizeFunction::collisions`] finds these features before any point is placed.
//!
//! **Source.** Section 5 of the paper; Mitchell and Vavasis (2000), Ruppert (1995), Miller and Talmor (reference \[14\]
//! of the paper). **Departures.** A cell uses the data of its parent, not its neighbours. The inherited data suffice
//! for the exact lfs at its centre. Smoothing is the minimum of cones, which is Lipschitz to the last bit of L.
//! Filtering removes the cones that lie above others.
//!
//! **Work and depth.** One evaluation of the rule per cell. The number of levels is logarithmic in the extent divided
//! by the larger of the smallest lfs and the smallest size.

pub mod collisions;
pub mod cones;
mod local;
pub mod regions;
pub mod user;

use septet_geometry::cost::Sweep;
use septet_geometry::range::scale;
use thiserror::Error;

use crate::distance::Features;
use crate::domain::Domain;
use crate::executor::{Evaluator, Sequential, Uncounted, always};
use crate::frame::Frame;
use crate::octree::{CellKey, Cube, Grown, Level, TooFine, grow};
use crate::space::Space;
use cones::{Cone, Cones};
use local::{Local, Terms};
use regions::Regions;
use user::{Constraints, Singularity, User};

/// The options of a size function.
#[derive(Clone, Debug, PartialEq)]
pub struct SizeOptions<P> {
    /// The Lipschitz constant L, strictly between 0 and 1.
    pub lipschitz: f64,
    /// The largest loss of g relative to f*, above 0 and at most `(1+L)/3`.
    pub loss: f64,
    /// The size constraints of the user, in the unit of the file.
    pub constraints: Constraints<P>,
    /// The largest number of cells.
    pub cells: u64,
}

impl<P> SizeOptions<P> {
    /// Creates options for L with the largest loss and no constraints.
    pub fn new(lipschitz: f64) -> Self {
        SizeOptions {
            lipschitz,
            loss: (1.0 + lipschitz) / 3.0,
            constraints: Constraints::default(),
            cells: 1 << 26,
        }
    }
}

/// A reason why a size function cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum SizeError {
    /// L is not strictly between 0 and 1.
    #[error("the Lipschitz constant {0} is not strictly between 0 and 1")]
    Lipschitz(f64),
    /// The loss is out of range.
    #[error("the loss {loss} is not above 0 and at most {most}")]
    Loss {
        /// The requested loss.
        loss: f64,
        /// The largest loss for this L.
        most: f64,
    },
    /// A size is not a positive finite number.
    #[error("the size {0} is not positive and finite")]
    Size(f64),
    /// A coordinate of the constraints is not finite.
    #[error("a coordinate of the size constraints is not finite")]
    Place,
    /// The domain or the sizes are too fine.
    #[error(transparent)]
    TooFine(#[from] TooFine),
}

/// The size function of a domain, in the domain's scaled coordinates.
#[derive(Clone, Debug)]
pub struct SizeFunction<P: Space> {
    user: User<P>,
    regions: Option<Regions<P>>,
    cones: Cones<P>,
    levels: Vec<Level>,
}

impl<P: Space> SizeFunction<P> {
    /// Builds the size function of a domain.
    ///
    /// # Errors
    /// Returns [`SizeError`] if options are out of range, or if the domain needs too many cells.
    pub fn new(domain: &Domain<P>, options: &SizeOptions<P>) -> Result<Self, SizeError> {
        always(Self::of_features(domain, &Features::new(domain), options, &Uncounted(Sequential)))
    }

    /// Builds the size function of some features of a domain. Outside their bounding box it is still L-Lipschitz, but
    /// the statement applies only inside.
    ///
    /// # Errors
    /// Returns the error of the machine if it fails. The inner result is that of [`Self::new`].
    pub fn of_features<M: Evaluator<P>>(
        domain: &Domain<P>,
        features: &Features<P>,
        options: &SizeOptions<P>,
        machine: &M,
    ) -> Result<Result<Self, SizeError>, M::Error> {
        let constraints = match scaled(options, &domain.simplices.frame) {
            Ok(constraints) => constraints,
            Err(error) => return Ok(Err(error)),
        };
        let user = User::new(options.lipschitz, &constraints, machine)?;
        if features.item_count() == 0 {
            let cones = Cones::new(options.lipschitz, Vec::new());
            let regions = Regions::new(options.lipschitz, domain);
            return Ok(Ok(SizeFunction { user, regions, cones, levels: Vec::new() }));
        }
        let (slope, loss) = (options.lipschitz, options.loss);
        let whole = features.is_whole().then_some(domain);
        let terms = Terms { features, domain: whole, user: &user, slope, loss, drops: true };
        let (grown, mut cones) = match tree(terms, options.cells, machine)? {
            Ok(grown) => grown,
            Err(too_fine) => return Ok(Err(too_fine.into())),
        };
        cones.extend(grown.leaves.into_iter().map(|(_, cone)| cone));
        if features.is_whole() {
            cones.extend(spacing(domain));
        }
        let cones = Cones::new(options.lipschitz, cones).filtered(machine)?;
        let regions = Regions::new(options.lipschitz, domain);
        Ok(Ok(SizeFunction { user, regions, cones, levels: grown.levels }))
    }

    /// Returns the size at a point.
    pub fn at(&self, x: P) -> f64 {
        self.at_counted(x, &mut Sweep::default())
    }

    /// Returns [`SizeFunction::at`], and counts one operation, and the visits of search trees.
    pub fn at_counted(&self, x: P, visits: &mut Sweep) -> f64 {
        visits.visit();
        let regions = self.regions.as_ref().map_or(f64::INFINITY, |r| r.at_counted(x, visits));
        let known = self.user.at_counted(x, visits).min(regions);
        self.cones.below_counted(x, known, visits).max(self.user.least)
    }

    /// Returns the Lipschitz constant.
    pub fn lipschitz(&self) -> f64 {
        self.cones.slope()
    }

    /// Returns the cones of the local feature size that remain after filtering.
    pub fn cones(&self) -> &[Cone<P>] {
        self.cones.all()
    }

    /// Returns the numbers of cells per level. Each level is one round.
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }
}

/// A size function that counts its operations.
pub trait Sizing<P>: Sync {
    /// Returns the size at a point.
    fn at(&self, x: P) -> f64;

    /// Returns the size at a point, and counts the operations of one processor.
    fn at_counted(&self, x: P, visits: &mut Sweep) -> f64;
}

/// Each evaluation of a function is one operation.
impl<P, F: Fn(P) -> f64 + Sync> Sizing<P> for F {
    fn at(&self, x: P) -> f64 {
        self(x)
    }

    fn at_counted(&self, x: P, visits: &mut Sweep) -> f64 {
        visits.visit();
        self(x)
    }
}

impl<P: Space> Sizing<P> for SizeFunction<P> {
    fn at(&self, x: P) -> f64 {
        SizeFunction::at(self, x)
    }

    fn at_counted(&self, x: P, visits: &mut Sweep) -> f64 {
        SizeFunction::at_counted(self, x, visits)
    }
}

/// Returns the cones at the corners of inner segments and lines.
fn spacing<P: Space>(domain: &Domain<P>) -> impl Iterator<Item = Cone<P>> {
    let at = |c: u32| domain.points()[domain.corners[c as usize] as usize];
    domain.flats.spacing.iter().map(move |&(c, size)| Cone { at: at(c), size })
}

/// The tree and its cones, and the cones that are always present.
type TreeAndFixed<P> = (Grown<Cone<P>>, Vec<Cone<P>>);

/// Returns the tree and its cones, and the cones that are always present.
fn tree<P: Space, M: Evaluator<P>>(
    terms: Terms<'_, P>,
    limit: u64,
    machine: &M,
) -> Result<Result<TreeAndFixed<P>, TooFine>, M::Error> {
    let rule = Local::new(terms, machine)?;
    let cube = Cube::around(&terms.features.bounds());
    let grown = match grow(&cube, &rule, &rule.root(cube.cell(CellKey::ROOT).centre), limit, machine)? {
        Ok(grown) => grown,
        Err(too_fine) => return Ok(Err(too_fine)),
    };
    let fixed = rule.middles().iter().filter(|c| c.size < terms.user.at(c.at));
    let fixed = fixed.copied().collect();
    Ok(Ok((grown, fixed)))
}

/// Converts the constraints to the coordinates of the domain. Values out of range are an error.
fn scaled<P: Space>(options: &SizeOptions<P>, frame: &Frame<P>) -> Result<Constraints<P>, SizeError> {
    let most = (1.0 + options.lipschitz) / 3.0;
    if !(options.lipschitz > 0.0 && options.lipschitz < 1.0) {
        return Err(SizeError::Lipschitz(options.lipschitz));
    }
    if !(options.loss > 0.0 && options.loss <= most) {
        return Err(SizeError::Loss { loss: options.loss, most });
    }
    let length = |h: f64| {
        let scaled = scale(P::splat(h), frame.exponent).coord(0);
        let fine = h > 0.0 && h.is_finite() && scaled > 0.0 && scaled.is_finite();
        if fine { Ok(scaled) } else { Err(SizeError::Size(h)) }
    };
    let place = |p: P| {
        let finite = (0..P::DIM).all(|i| p.coord(i).is_finite());
        if finite { Ok(frame.inward(p)) } else { Err(SizeError::Place) }
    };
    let constraints = &options.constraints;
    let field = constraints.field.iter().map(|c| Ok(Cone { at: place(c.at)?, size: length(c.size)? }));
    let singular = constraints.singularities.iter().map(|&(s, size)| {
        let s = match s {
            Singularity::Point(p) => Singularity::Point(place(p)?),
            Singularity::Line(p, q) => Singularity::Line(place(p)?, place(q)?),
        };
        Ok((s, length(size)?))
    });
    Ok(Constraints {
        most: constraints.most.map(length).transpose()?,
        least: constraints.least.map(length).transpose()?,
        field: field.collect::<Result<_, SizeError>>()?,
        singularities: singular.collect::<Result<_, SizeError>>()?,
    })
}

#[cfg(test)]
pub(crate) mod tests;
