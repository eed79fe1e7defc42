//! All options of a run, as given or by default.

use std::path::PathBuf;

use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use septet_core::Settled;
use septet_core::Spec;
use septet_core::spec::{OPTIONS, Row, Setting};

use super::context::RunContext;

/// The options of a run as requested, except `leaf`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Parameters {
    /// `triangulate` or `simulate`.
    pub command: &'static str,
    /// The input as given on the command line.
    pub input: String,
    /// The outputs as given on the command line.
    pub outputs: Vec<PathBuf>,
    /// The column or the file of the weights, as given on the command line; absent without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weights: Option<String>,
    /// The column or the file of the radii, as given on the command line; absent without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radii: Option<String>,
    /// All options, of which `leaf` follows.
    #[serde(flatten)]
    pub options: Requested,
    /// Largest number of points in a leaf, as the run used it.
    pub leaf: u64,
    /// Whether septet chose the leaf size.
    pub leaf_auto: bool,
    /// Lipschitz constant of a generated f-spaced set.
    pub lipschitz: Option<f64>,
    /// Maximum number of splaying rounds before the fallback. `None` for `6 log2 n`.
    pub exchange_cap: Option<u32>,
}

/// The values of options, in the order of their rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Requested(Vec<(&'static str, Setting)>);

impl Requested {
    /// Returns the values of options.
    pub(super) fn of<S: Default + 'static>(
        rows: impl IntoIterator<Item = &'static Row<S>>,
        spec: &S,
    ) -> Self {
        Requested(rows.into_iter().map(|row| (row.key, row.get(spec))).collect())
    }

    /// Returns the values of both.
    pub(super) fn and(mut self, other: Requested) -> Self {
        self.0.extend(other.0);
        self
    }

    /// Returns the text of an option, which is empty if it is not given.
    pub fn text(&self, key: &str) -> String {
        let value = self.0.iter().find(|(name, _)| *name == key);
        value.and_then(|(_, value)| value.text()).unwrap_or_default()
    }

    /// Replaces the value of an option.
    pub(super) fn set(&mut self, key: &str, value: &Setting) {
        self.0.iter_mut().filter(|(name, _)| *name == key).for_each(|option| option.1 = value.clone());
    }
}

impl Serialize for Requested {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(Some(self.0.len()))?;
        for (key, value) in &self.0 {
            map.serialize_entry(key, value)?;
        }
        map.end()
    }
}

/// The options that the table lists, without `leaf`.
#[cfg(feature = "schema")]
impl schemars::JsonSchema for Requested {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Requested".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        crate::option_schema::Fields::default().and(run_rows()).object()
    }
}

/// Returns the rows of [`Requested`] options of a run: all but `leaf`.
fn run_rows() -> impl Iterator<Item = &'static Row> {
    OPTIONS.iter().filter(|row| row.key != "leaf")
}

impl Parameters {
    /// Returns the parameters of a specification as requested.
    pub(super) fn of(spec: &Spec, context: &RunContext<'_>, leaf: u64) -> Self {
        Parameters {
            command: context.command,
            input: context.input.to_owned(),
            outputs: context.outputs.to_vec(),
            weights: context.weights.map(str::to_owned),
            radii: context.radii.map(str::to_owned),
            options: Requested::of(run_rows(), spec),
            leaf,
            leaf_auto: spec.tree.leaf.is_none(),
            lipschitz: spec.recursion.spacing,
            exchange_cap: spec.planted.exchange_cap,
        }
    }
}

/// The options that the run settled, as it used them.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SettledReport {
    /// Number of workers.
    pub workers: u32,
    /// Number of threads of each process.
    pub threads: usize,
    /// Largest number of points in a leaf.
    pub leaf: u64,
    /// Largest expected number of samples of a draw.
    pub samples: u64,
    /// Number of great circles of a draw.
    pub tries: u32,
}

impl SettledReport {
    /// Returns the options that a run settled.
    pub(super) fn of(settled: &Settled, context: &RunContext<'_>) -> Self {
        let Settled { workers, leaf, samples, tries, .. } = *settled;
        SettledReport { workers, threads: context.threads, leaf, samples, tries }
    }
}
