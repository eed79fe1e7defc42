//! Rules of the source that no compiler checks.

mod cycles;
mod map;
mod prose;
mod rules;
mod source;
