//! Rules of the source that no compiler checks.

mod cycles;
mod rules;
mod source;
