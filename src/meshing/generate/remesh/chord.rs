//! Chords of ridges. A chord connects two consecutive vertices.

use crate::generate::balls::Ball;
use crate::generate::generator::Candidate;
use crate::mesh::Carrier;
use crate::points::conflicts::Site;
use crate::space::Space;

/// A chord between two consecutive vertices of a ridge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chord<P> {
    pub(super) ends: [u32; 2],
    /// The point that divides the part of the ridge between the ends.
    pub(super) middle: P,
    pub(super) segment: u32,
    /// The smallest ball of the chord.
    pub(super) ball: Ball<P>,
}

impl<P: Space> Chord<P> {
    /// Returns the dividing point as a candidate. It conflicts with points closer than half the chord.
    pub(super) fn candidate(&self) -> Candidate<P> {
        (Site { at: self.middle, size: self.ball.radius2.sqrt() }, Carrier::Segment(self.segment))
    }
}
