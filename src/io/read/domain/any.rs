//! A domain as read, of the plane or of space.

use glam::{DVec2, DVec3};
use septet_meshing::input::Input;

/// A domain in the plane or in space.
#[derive(Clone, Debug, PartialEq)]
pub enum AnyInput {
    /// Of the plane.
    Plane(Input<DVec2>),
    /// Of space.
    Space(Input<DVec3>),
}

/// The domain of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct DomainFile {
    /// The domain as stated.
    pub input: AnyInput,
    /// Remarks for the user, one line each.
    pub notes: Vec<String>,
    /// The id the file gave to its first point (and so to its first facet), 0 or 1.
    pub first_id: u64,
}
