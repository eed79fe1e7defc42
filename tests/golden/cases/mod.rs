//! All cases in the order in which they run: long ones last.

mod commands;
mod machine;
mod meshes;

use crate::record::Record;

/// A case: its name and what it does.
pub struct Case {
    /// Without spaces.
    pub name: String,
    /// What it does.
    pub run: Box<dyn Fn(&mut Record) + Sync>,
    /// Whether some of its groups must draw again.
    pub retries: bool,
}

impl Case {
    fn new(name: impl Into<String>, run: impl Fn(&mut Record) + Sync + 'static) -> Self {
        Case { name: name.into(), run: Box::new(run), retries: false }
    }
}

/// Every case.
pub fn all() -> Vec<Case> {
    let mut cases = machine::cases();
    cases.extend(commands::cases());
    cases.extend(meshes::cases());
    cases.push(commands::last());
    cases
}
