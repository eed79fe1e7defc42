//! The kinds of messages.

use super::Body;

/// The names of all kinds, in the order of [`Body`].
pub const KINDS: [&str; 39] = [
    "start",
    "block",
    "plan",
    "samples",
    "sphere",
    "counts",
    "decision",
    "move",
    "query",
    "answer",
    "summary",
    "children",
    "frame",
    "sample-stars",
    "choice",
    "ghosts",
    "seam",
    "reverse",
    "items",
    "set-counts",
    "set-decision",
    "lists",
    "fingerprint",
    "fingerprint-list",
    "propose",
    "object",
    "joined",
    "left",
    "merged",
    "outcome",
    "gather",
    "region",
    "cells",
    "piece",
    "selected",
    "edges",
    "sets",
    "ledger",
    "view",
];

impl<P> Body<P> {
    /// Returns the name of the kind in traces and faults, one of [`KINDS`].
    pub fn kind(&self) -> &'static str {
        match self {
            Body::Start { .. } => "start",
            Body::Block(_) => "block",
            Body::Plan { .. } => "plan",
            Body::Samples(_) => "samples",
            Body::Sphere(_) => "sphere",
            Body::Counts { .. } => "counts",
            Body::Decision { .. } => "decision",
            Body::Move(_) => "move",
            Body::Query(_) => "query",
            Body::Reply(_) => "answer",
            Body::Summary(_) => "summary",
            Body::Children(_) => "children",
            Body::Frame(_) => "frame",
            Body::SampleStars(_) => "sample-stars",
            Body::Choice(_) => "choice",
            Body::Ghosts(_) => "ghosts",
            Body::Seam { .. } => "seam",
            Body::Reverse { .. } => "reverse",
            Body::Items { .. } => "items",
            Body::SetCounts(_) => "set-counts",
            Body::SetDecision(_) => "set-decision",
            Body::Lists(_) => "lists",
            Body::Fingerprint(_) => "fingerprint",
            Body::FingerprintList(_) => "fingerprint-list",
            Body::Propose { .. } => "propose",
            Body::Object { .. } => "object",
            Body::Joined(_) => "joined",
            Body::Left(_) => "left",
            Body::Merged(_) => "merged",
            Body::Outcome(_) => "outcome",
            Body::Gather(_) => "gather",
            Body::Region { .. } => "region",
            Body::Cells { .. } => "cells",
            Body::Piece { .. } => "piece",
            Body::Selected { .. } => "selected",
            Body::Edges(_) => "edges",
            Body::Sets { .. } => "sets",
            Body::Ledger(_) => "ledger",
            Body::View(_) => "view",
        }
    }

    /// Returns `true` for messages that carry measurements. They are not billed.
    pub fn is_instrument(&self) -> bool {
        matches!(self, Body::Ledger(_) | Body::View(_) | Body::Sets { .. })
    }

    /// Returns `true` for input and results in bulk, which the coordinator's control traffic excludes.
    pub fn is_bulk(&self) -> bool {
        matches!(
            self,
            Body::Block(_) | Body::Cells { .. } | Body::Piece { .. } | Body::Selected { .. } | Body::Edges(_)
        )
    }
}
