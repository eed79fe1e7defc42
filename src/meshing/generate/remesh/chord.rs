//! A chord of a ridge: two vertices that follow each other along it.

use crate::generate::balls::Ball;
use crate::mesh::Carrier;
use crate::points::conflicts::Site;
use crate::space::Space;

/// A piece of a ridge between two vertices.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chord<P> {
    pub(super) ends: [u32; 2],
    /// Where the ridge's piece is divided, and the segment that it lies on.
    pub(super) middle: P,
    pub(super) segment: u32,
    /// The chord's smallest ball.
    pub(super) ball: Ball<P>,
}

impl<P: Space> Chord<P> {
    /// The middle as a candidate; it gives way to whatever is closer than half of it.
    pub(super) fn candidate(&self) -> (Site<P>, Carrier) {
        (Site { at: self.middle, size: self.ball.radius2.sqrt() }, Carrier::Segment(self.segment))
    }
}
