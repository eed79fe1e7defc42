//! The journal of a call of `reproduce`: the figures of every claim that the call has checked.
//!
//! After an interruption, the same call continues with the claims that its journal does not contain.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::experiment::{Entry, Journal, JournalError, Stamp, read_entries};

use septet_core::spec::Words;

use super::{CheckedClaim, Claim, Figure, LabOptions};

/// Name and version of the schema of a line.
const SCHEMA: &str = "septet-claims-journal/1";

/// The figures of a checked claim.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct ClaimLine {
    schema: String,
    version: String,
    /// The options that determine the figures.
    options: String,
    claim: String,
    figures: Vec<Figure>,
}

impl Entry for ClaimLine {
    const WHAT: &'static str = "checked claims";
    const SCHEMA: &'static str = SCHEMA;
    type Key = String;

    fn stamp(&self) -> Stamp<'_> {
        Stamp { schema: &self.schema, version: &self.version, words: &self.options }
    }

    fn key(&self) -> String {
        self.claim.clone()
    }
}

/// The journal of a call, open for appending.
#[derive(Debug)]
pub struct ClaimJournal {
    journal: Journal<ClaimLine>,
    options: String,
    lines: Vec<ClaimLine>,
}

impl ClaimJournal {
    /// Opens or creates the journal of a call with these options.
    ///
    /// # Errors
    /// Fails if the file cannot be read or written, or belongs to other options or another version.
    pub fn open(path: &Path, options: &LabOptions) -> Result<ClaimJournal, JournalError> {
        let options = words(options);
        let journal = Journal::open(path, &options)?;
        let lines = read_entries::<ClaimLine>(path)?.lines;
        Ok(ClaimJournal { journal, options, lines })
    }

    /// Returns the checked claim, if the journal contains its figures.
    pub fn checked(&self, claim: &Claim) -> Option<CheckedClaim> {
        let line = self.lines.iter().find(|line| line.claim == claim.name)?;
        Some(CheckedClaim::of(claim, line.figures.clone()))
    }

    /// Appends a checked claim, and waits until it is on disk.
    ///
    /// # Errors
    /// Fails if the line cannot be written.
    pub fn append(&mut self, checked: &CheckedClaim) -> Result<(), JournalError> {
        self.journal.append(&ClaimLine {
            schema: SCHEMA.to_string(),
            version: env!("CARGO_PKG_VERSION").to_string(),
            options: self.options.clone(),
            claim: checked.name.to_string(),
            figures: checked.figures.clone(),
        })?;
        self.journal.sync()
    }
}

/// Returns the options that determine the figures, in words.
fn words(options: &LabOptions) -> String {
    let LabOptions { extent, seed, correction, fault, .. } = options;
    let fault = fault.map_or_else(String::new, |fault| format!(" --fault {fault}"));
    format!("--{} --seed {seed} --neighbours {}{fault}", extent.name(), correction.name())
}
