//! Rules of the source that no compiler checks.

mod cycles;
mod map;
mod rules;
mod source;
