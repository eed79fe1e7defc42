//! The kinds of messages.

use super::Body;

/// The names of all kinds, in the order of [`Body`].
pub const KINDS: [&str; 31] = [
    "start",
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
];

impl<P> Body<P> {
    /// Returns the name of the kind in traces and faults, one of [`KINDS`].
    pub fn kind(&self) -> &'static str {
        match self {
            Body::Start { .. } => "start",
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
        }
    }
}
