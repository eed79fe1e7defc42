//! Rules of the source that no compiler checks.

mod cycles;
mod map;
mod products;
mod rules;
mod source;
