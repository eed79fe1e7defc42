//! Constrained triangulations of domains, by dimension.

use glam::{DVec2, DVec3};

use crate::constrained::{constrain, constrain_and_fill};
use crate::domain::Domain;
use crate::facet::Triangulate;
use crate::generate::{GeneratedMesh, GenerationError, MeshMachine, Rules};
use crate::plane;

/// A mesh, and the operations of the sequential part of its generation.
pub type Counted<P, E> = Result<(GeneratedMesh<P>, u64), GenerationError<E>>;

/// A dimension in which the constrained triangulation of a domain can be requested, as it is or refined.
pub trait AsItIs: Triangulate {
    /// Returns the constrained triangulation of a domain. In space, it has points on edges that cannot be kept otherwise.
    ///
    /// # Errors
    /// Returns the error of the machine, or [`GenerationError::Missing`].
    fn as_it_is<M: MeshMachine<Self>>(
        domain: &Domain<Self>,
        rules: Rules<'_, Self>,
        machine: &mut M,
    ) -> Counted<Self, M::Error>;

    /// Adds points inside the domain to its constrained triangulation, for the sizes of the rules.
    ///
    /// # Errors
    /// Returns the error of the machine, [`GenerationError::Missing`], [`GenerationError::TooMany`] or
    /// [`GenerationError::Unsupported`].
    fn filled<M: MeshMachine<Self> + Sync>(
        domain: &Domain<Self>,
        rules: Rules<'_, Self>,
        machine: &mut M,
    ) -> Counted<Self, M::Error>;

    /// Refines the constrained triangulation of a domain to a least angle in degrees and to the sizes of the rules.
    ///
    /// # Errors
    /// Returns the error of the machine, [`GenerationError::TooMany`] or [`GenerationError::Unsupported`].
    fn refined<M: MeshMachine<Self>>(
        domain: &Domain<Self>,
        rules: Rules<'_, Self>,
        degrees: f64,
        machine: &mut M,
    ) -> Counted<Self, M::Error>;
}

impl AsItIs for DVec2 {
    fn as_it_is<M: MeshMachine<Self>>(
        domain: &Domain<Self>,
        _: Rules<'_, Self>,
        machine: &mut M,
    ) -> Counted<Self, M::Error> {
        plane::as_it_is(domain, machine)
    }

    fn filled<M: MeshMachine<Self> + Sync>(
        _: &Domain<Self>,
        _: Rules<'_, Self>,
        _: &mut M,
    ) -> Counted<Self, M::Error> {
        Err(GenerationError::Unsupported("a boundary without new points is for domains in space only"))
    }

    fn refined<M: MeshMachine<Self>>(
        domain: &Domain<Self>,
        rules: Rules<'_, Self>,
        degrees: f64,
        machine: &mut M,
    ) -> Counted<Self, M::Error> {
        plane::refined(domain, rules, degrees, machine)
    }
}

impl AsItIs for DVec3 {
    fn as_it_is<M: MeshMachine<Self>>(
        domain: &Domain<Self>,
        rules: Rules<'_, Self>,
        machine: &mut M,
    ) -> Counted<Self, M::Error> {
        constrain(domain, rules, machine).map(|made| (made, 0))
    }

    fn filled<M: MeshMachine<Self> + Sync>(
        domain: &Domain<Self>,
        rules: Rules<'_, Self>,
        machine: &mut M,
    ) -> Counted<Self, M::Error> {
        constrain_and_fill(domain, rules, machine).map(|made| (made, 0))
    }

    fn refined<M: MeshMachine<Self>>(
        _: &Domain<Self>,
        _: Rules<'_, Self>,
        _: f64,
        _: &mut M,
    ) -> Counted<Self, M::Error> {
        Err(GenerationError::Unsupported("refinement of a constrained triangulation is for the plane only"))
    }
}
