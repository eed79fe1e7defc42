//! Refusal of options that would have no effect.

use super::errors::{Code, Failure};

/// Refuses an option that is given without the setting that it needs. `is_met` is whether that setting is given.
pub fn needs(option: &str, is_given: bool, needed: &str, is_met: bool) -> Result<(), Failure> {
    if is_met || !is_given {
        return Ok(());
    }
    let message = format!("{option} has no effect without {needed}");
    Err(Failure::new(Code::Usage, message).help(format!("add {needed}, or omit {option}")))
}

/// Refuses an option that is given together with a setting that disables it.
pub fn excludes(option: &str, is_given: bool, other: &str, is_set: bool) -> Result<(), Failure> {
    if !is_set || !is_given {
        return Ok(());
    }
    let message = format!("{option} has no effect with {other}");
    Err(Failure::new(Code::Usage, message).help(format!("omit {option} or {other}")))
}
