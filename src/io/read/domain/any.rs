//! A domain in the plane or in space, as it was read.

use glam::{DVec2, DVec3};
use septet_meshing::input::Input;

/// A domain in the plane or in space.
#[derive(Clone, Debug, PartialEq)]
pub enum AnyInput {
    /// A domain in the plane.
    Plane(Input<DVec2>),
    /// A domain in space.
    Space(Input<DVec3>),
}

/// The domain of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct DomainFile {
    /// The domain as the file describes it.
    pub input: AnyInput,
    /// Notes for the user, one line each.
    pub notes: Vec<String>,
    /// The id of the first point and of the first facet in the file: 0 or 1.
    pub first_id: u64,
}
