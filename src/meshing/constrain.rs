//! Constrained triangulations of domains, by dimension.

use glam::{DVec2, DVec3};

use crate::constrained::{Wish, constrain, constrain_and_refine};
use crate::domain::Domain;
use crate::facet::Triangulate;
use crate::generate::{GeneratedMesh, GenerationError, MeshMachine, Rules};
use crate::plane;

/// A mesh, and the operations of the sequential part of its generation.
pub type Counted<P, E> = Result<(GeneratedMesh<P>, u64), GenerationError<E>>;

/// A dimension in which the constrained triangulation of a domain can be requested, as it is or refined.
pub trait Constrain: Triangulate {
    /// Returns the constrained triangulation of a domain. In space, it has points on edges that cannot be kept otherwise.
    ///
    /// # Errors
    /// Returns the error of the machine, or [`GenerationError::Missing`].
    fn as_it_is<M: MeshMachine<Self>>(
        domain: &Domain<Self>,
        rules: Rules<'_, Self>,
        machine: &mut M,
    ) -> Counted<Self, M::Error>;

    /// Refines the constrained triangulation of a domain to a ratio of circumradius and shortest edge, and to the sizes
    /// of the rules.
    ///
    /// # Errors
    /// Returns the error of the machine, [`GenerationError::TooMany`] or [`GenerationError::Unsupported`].
    fn refined<M: MeshMachine<Self>>(
        domain: &Domain<Self>,
        rules: Rules<'_, Self>,
        wish: Wish,
        machine: &mut M,
    ) -> Counted<Self, M::Error>;
}

impl Constrain for DVec2 {
    fn as_it_is<M: MeshMachine<Self>>(
        domain: &Domain<Self>,
        _: Rules<'_, Self>,
        machine: &mut M,
    ) -> Counted<Self, M::Error> {
        plane::as_it_is(domain, machine)
    }

    fn refined<M: MeshMachine<Self>>(
        domain: &Domain<Self>,
        rules: Rules<'_, Self>,
        wish: Wish,
        machine: &mut M,
    ) -> Counted<Self, M::Error> {
        if !wish.divides {
            return Err(GenerationError::Unsupported(
                "a boundary without new points is for domains in space only",
            ));
        }
        plane::refined(domain, rules, (0.5 / wish.ratio).asin().to_degrees(), machine)
    }
}

impl Constrain for DVec3 {
    fn as_it_is<M: MeshMachine<Self>>(
        domain: &Domain<Self>,
        rules: Rules<'_, Self>,
        machine: &mut M,
    ) -> Counted<Self, M::Error> {
        constrain(domain, rules, machine).map(|made| (made, 0))
    }

    fn refined<M: MeshMachine<Self>>(
        domain: &Domain<Self>,
        rules: Rules<'_, Self>,
        wish: Wish,
        machine: &mut M,
    ) -> Counted<Self, M::Error> {
        constrain_and_refine(domain, rules, wish, machine)
    }
}
