//! The size function: how far apart points of the mesh are to be.
//!
//! **Statement.** Let Q be a part of the space that holds the domain, and `f*(x) = inf_{y in Q} (lfs(y) + L |x - y|)`, the
//! largest L-Lipschitz function that is nowhere in Q above the local feature size. A tree of cells gives finitely many
//! cones whose least value g satisfies
//! ```text
//! (1 - loss) f*(x) <= g(x) <= f*(x) <= lfs(x),    L lfs(x) <= f*(x)
//! ```
//! for all x in Q. Q is a cube around the domain without the cells that lie outside of it and meet no feature (the
//! sizes of a narrow gap between two parts of a surface are nobody's concern but those parts'); where the features are not all
//! those of the domain, it is the cube. The size function is `f(x) = max(least, min(user(x), regions(x), g(x)))`: L-Lipschitz, because
//! all its parts are. (With a smallest size the first inequality holds for `max(least, .)` of both sides.)
//!
//! *Proof.* Let m be the centre of a cell, r its radius, y a point in it. lfs is 1-Lipschitz, so the cell's cone
//! satisfies `a + L |x - m| = lfs(m) - (1+L) r + L |x - m| <= lfs(y) + L |x - y|`. If every cell were kept, this
//! would say `g <= f*`. A cell is dropped (see `local`) for the user's function or the cone at the middle of a
//! simplex, which f has anyway, or because some z has `lfs(z) + L |m - z|` strictly below a; then
//! `lfs(z) + L |x - z|` is below `a + L |x - m|`, and the cell of z takes over: it is not outside of Q, since z lies on a
//! feature, or on the same side of all of them as m, where m is inside of the domain. Values fall strictly, so no cell
//! comes twice, and the last one is kept. A kept cell has `(1+L) r <= loss lfs(m)`, so `a >= (1 - loss) lfs(m)` and
//! its cone is at least `(1 - loss) f*(x)`; so are the cones of the middles. Last, lfs(y) is at least
//! `lfs(x) - |x - y|`, so `lfs(y) + L |x - y| >= L lfs(x)` as long as L is at most 1. QED.
//!
//! Cells that are not dropped are split iff `max(lfs(m), least) < k s`, `k = (1+L) sqrt(d) / (2 loss)`; for
//! `loss <= (1+L) / 3` that is `k >= 1.5 sqrt(d)`, so without drops the tree is balanced ([`crate::octree`]). Every
//! leaf then has `lfs` between `(k - sqrt(d)/2) s` and `(2 k + 1.5 sqrt(d)) s`.
//!
//! Where features meet at an angle, lfs does not fall to zero along them, but points on the two come closer and
//! closer: [`SizeFunction::collisions`] finds these places before any point is placed.
//!
//! **Source.** Section 5 of the paper; Mitchell and Vavasis (2000), Ruppert (1995), Miller and Talmor (its \[14\]).
//! **Departures.** A cell looks at its parent, not at its neighbours: what it is handed suffices for the exact lfs
//! at its centre. Smoothing is the minimum of cones, which is Lipschitz to the last bit of L, filtering takes away
//! the cones that lie above others.
//!
//! **Work and depth.** One call of the rule for each cell; the number of levels is logarithmic in the extent over
//! the smallest lfs that is not below the smallest size wished.

pub mod collisions;
pub mod cones;
mod local;
pub mod regions;
pub mod user;

use septet_geometry::range::scale;
use thiserror::Error;

use crate::distance::Features;
use crate::domain::Domain;
use crate::executor::{Executor, Sequential};
use crate::octree::{Cube, Grown, Key, Level, TooFine, grow};
use crate::space::Space;
use cones::{Cone, Cones};
use local::{Local, Terms};
use regions::Regions;
use user::{Constraints, Singularity, User};

/// How a size function is made.
#[derive(Clone, Debug, PartialEq)]
pub struct SizeOptions<P> {
    /// The Lipschitz constant L, between 0 and 1, both exclusive.
    pub lipschitz: f64,
    /// How far g may stay below f*, as a part of it; above 0 and at most `(1+L)/3`.
    pub loss: f64,
    /// What the user wishes, in the unit of the file.
    pub constraints: Constraints<P>,
    /// The largest number of cells.
    pub cells: u64,
}

impl<P> SizeOptions<P> {
    /// L, the largest loss, and no wishes.
    pub fn new(lipschitz: f64) -> Self {
        SizeOptions {
            lipschitz,
            loss: (1.0 + lipschitz) / 3.0,
            constraints: Constraints::default(),
            cells: 1 << 26,
        }
    }
}

/// Why there is no size function.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum SizeError {
    /// L is not between 0 and 1.
    #[error("the Lipschitz constant is {0}: it must lie between 0 and 1, both exclusive")]
    Lipschitz(f64),
    /// The loss is out of its range.
    #[error("the loss is {loss}: it must be above 0 and at most {most}")]
    Loss {
        /// As given.
        loss: f64,
        /// The largest one for this L.
        most: f64,
    },
    /// A size is not a positive number.
    #[error("a size is {0}: sizes must be positive and finite")]
    Size(f64),
    /// A place is not finite.
    #[error("a place of the sizes wished has a coordinate that is not finite")]
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
    /// Makes it.
    ///
    /// # Errors
    /// [`SizeError`], for options out of range and for domains that are too fine for the number of cells.
    pub fn new(domain: &Domain<P>, options: &SizeOptions<P>) -> Result<Self, SizeError> {
        Self::of_features(domain, &Features::new(domain), options, &Sequential)
    }

    /// Makes that of some features of a domain. Outside of their box it is L-Lipschitz still, and the statement is
    /// about the inside alone.
    ///
    /// # Errors
    /// As for [`Self::new`].
    pub fn of_features(
        domain: &Domain<P>,
        features: &Features<P>,
        options: &SizeOptions<P>,
        executor: &impl Executor,
    ) -> Result<Self, SizeError> {
        let constraints = scaled(options, domain.simplices.exponent)?;
        let user = User::new(options.lipschitz, &constraints);
        if features.item_count() == 0 {
            let cones = Cones::new(options.lipschitz, Vec::new());
            let regions = Regions::new(options.lipschitz, domain);
            return Ok(SizeFunction { user, regions, cones, levels: Vec::new() });
        }
        let (slope, loss) = (options.lipschitz, options.loss);
        let whole = features.is_whole().then_some(domain);
        let terms = Terms { features, domain: whole, user: &user, slope, loss, drops: true };
        let (grown, mut cones) = tree(terms, options.cells, executor)?;
        cones.extend(grown.leaves.into_iter().map(|(_, cone)| cone));
        let cones = Cones::new(options.lipschitz, cones).filtered(executor);
        let regions = Regions::new(options.lipschitz, domain);
        Ok(SizeFunction { user, regions, cones, levels: grown.levels })
    }

    /// The size at a point.
    pub fn at(&self, x: P) -> f64 {
        let regions = self.regions.as_ref().map_or(f64::INFINITY, |r| r.at(x));
        self.cones.below(x, self.user.at(x).min(regions)).max(self.user.least)
    }

    /// The Lipschitz constant.
    pub fn lipschitz(&self) -> f64 {
        self.cones.slope()
    }

    /// The cones of the local feature size that are left after filtering.
    pub fn cones(&self) -> &[Cone<P>] {
        self.cones.all()
    }

    /// Cells by level: as many rounds.
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }
}

/// Cones that stand in any case.
type FixedCones<P> = Vec<Cone<P>>;

/// The tree with its cones, and the cones that stand in any case.
fn tree<P: Space>(
    terms: Terms<'_, P>,
    limit: u64,
    executor: &impl Executor,
) -> Result<(Grown<Cone<P>>, FixedCones<P>), TooFine> {
    let rule = Local::new(terms, executor);
    let cube = Cube::around(&terms.features.bounds());
    let grown = grow(&cube, &rule, &rule.root(cube.cell(Key::ROOT).centre), limit, executor)?;
    let fixed = rule.middles().iter().filter(|c| c.size < terms.user.at(c.at));
    let fixed = fixed.copied().collect();
    Ok((grown, fixed))
}

/// The wishes in the domain's coordinates; what is out of range is refused.
fn scaled<P: Space>(options: &SizeOptions<P>, exponent: i32) -> Result<Constraints<P>, SizeError> {
    let most = (1.0 + options.lipschitz) / 3.0;
    if !(options.lipschitz > 0.0 && options.lipschitz < 1.0) {
        return Err(SizeError::Lipschitz(options.lipschitz));
    }
    if !(options.loss > 0.0 && options.loss <= most) {
        return Err(SizeError::Loss { loss: options.loss, most });
    }
    let length = |h: f64| {
        let scaled = scale(P::splat(h), exponent).coord(0);
        let fine = h > 0.0 && h.is_finite() && scaled > 0.0 && scaled.is_finite();
        if fine { Ok(scaled) } else { Err(SizeError::Size(h)) }
    };
    let place = |p: P| {
        let finite = (0..P::DIM).all(|i| p.coord(i).is_finite());
        if finite { Ok(scale(p, exponent)) } else { Err(SizeError::Place) }
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
