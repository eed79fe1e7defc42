//! Rules of the source that no compiler checks.

mod cycles;
mod map;
mod phases;
mod products;
mod prose;
mod rules;
mod source;
mod syntax;
mod tables;
