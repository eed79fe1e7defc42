//! `septet schema`: JSON Schemas (draft 2020-12) of the reports and of cost traces, derived from their Rust types.

use clap::{Args, ValueEnum};
use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;
use schemars::{JsonSchema, Schema};
use septet_lab::baselines::BaselineReport;
use septet_lab::claims::ClaimReport;
use septet_lab::experiment::Line;
use septet_lab::experiment::fit::FitReport;
use septet_lab::report::mesh::MeshReport;
use septet_lab::report::{CostLine, RunReport, VerifyReport};
use serde::{Serialize, Serializer};
use serde_json::Value;

use super::errors::{Code, Failure};
use super::files;
use super::fit::SpeedupReport;
use super::predict::PredictReport;

/// Options of `septet schema`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  septet schema run > run.schema.json
  septet schema mesh")]
pub struct SchemaArgs {
    /// Report to describe
    #[arg(value_enum)]
    report: Which,
}

/// The reports in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Which {
    /// `--json` of `septet triangulate` and `septet simulate`
    Run,
    /// `--json` of `septet mesh`
    Mesh,
    /// A line of `septet scale`
    Scale,
    /// `--json` of `septet fit`
    Fit,
    /// `--json` of `septet fit --speedup`
    Speedup,
    /// `--json` of `septet reproduce`
    Claims,
    /// `--json` of `septet predict`
    Predict,
    /// `--json` of `septet rival`
    Rival,
    /// `--json` of `septet verify`
    Verify,
    /// A line of `--cost-trace` of `septet simulate`
    Cost,
}

impl Which {
    /// Returns the schema.
    fn schema(self) -> Schema {
        match self {
            Which::Run => derived::<RunReport>("Report of septet triangulate and septet simulate"),
            Which::Mesh => derived::<MeshReport>("Report of septet mesh"),
            Which::Scale => derived::<Line>("A line of septet scale"),
            Which::Fit => derived::<FitReport>("Report of septet fit"),
            Which::Speedup => derived::<SpeedupReport>("Report of septet fit --speedup"),
            Which::Claims => derived::<ClaimReport>("Report of septet reproduce"),
            Which::Predict => derived::<PredictReport<'_>>("Report of septet predict"),
            Which::Rival => derived::<BaselineReport>("Report of septet rival"),
            Which::Verify => derived::<VerifyReport<'_>>("Report of septet verify"),
            Which::Cost => derived::<CostLine<'_>>("A line of a cost trace of septet"),
        }
    }
}

/// Prints a schema to standard output.
pub fn run(args: &SchemaArgs) -> Result<(), Failure> {
    let schema = args.report.schema();
    let mut text = serde_json::to_string_pretty(&Ordered::schema(schema.as_value()))
        .map_err(|e| Failure::new(Code::Failed, format!("the schema cannot be written: {e}")))?;
    text.push('\n');
    Ok(files::print(&text)?)
}

/// Returns the schema of what a type writes.
fn derived<T: JsonSchema>(title: &str) -> Schema {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    let settings = settings.with_transform(RecursiveTransform(finish));
    let mut schema = settings.into_generator().into_root_schema_for::<T>();
    schema.insert("title".to_owned(), title.into());
    schema
}

/// Completes one object of a schema: a plain description, no other properties, no null for a property that is left out
/// instead, null for a number that is not finite, and nothing about reading.
fn finish(schema: &mut Schema) {
    if let Some(Value::String(text)) = schema.get("description") {
        let text = plain(text);
        schema.insert("description".to_owned(), text.into());
    }
    if schema.get("properties").is_some() && schema.get("additionalProperties").is_none() {
        schema.insert("additionalProperties".to_owned(), false.into());
        let required = schema.get("required").and_then(Value::as_array).cloned().unwrap_or_default();
        let properties = schema.get_mut("properties").and_then(Value::as_object_mut).into_iter().flatten();
        for (name, property) in properties {
            if !required.contains(&Value::from(name.as_str())) {
                let types = property.get_mut("type").and_then(Value::as_array_mut);
                if let Some(types) = types {
                    types.retain(|name| name != "null");
                }
            }
            // Only the tags of enums have a single value and no doc comment.
            if property.get("const").is_some() && property.get("description").is_none() {
                property["description"] = "Name of this alternative.".into();
            }
        }
    }
    schema.remove("default");
    schema.remove("readOnly");
    let format = schema.remove("format");
    if format.is_some_and(|format| format == "double") {
        schema.insert("type".to_owned(), Value::from(["number", "null"].as_slice()));
    }
}

/// Returns a doc comment in the terms of JSON: on one line, without links, and with `null` for `None`.
fn plain(doc: &str) -> String {
    let mut text = doc.split_whitespace().collect::<Vec<_>>().join(" ").replace("`None`", "`null`");
    let mut from = 0;
    while let Some(open) = text[from..].find('[').map(|at| from + at) {
        let Some(close) = text[open..].find(']').map(|at| open + at) else { break };
        let label = text[open + 1..close].to_owned();
        let target = text[close + 1..].strip_prefix('(').and_then(|rest| rest.find(')')).map(|end| end + 2);
        from = open + 1;
        if target.is_some() || label.starts_with('`') {
            // The path of a field ends with its name in the report.
            let name = label.rsplit_once("::").map_or(label.clone(), |(_, name)| format!("`{name}"));
            text.replace_range(open..close + 1 + target.unwrap_or(0), &name);
            from = open + name.len();
        }
    }
    text
}

/// A schema in the order in which a person reads it: the description first, and the properties in the order of the
/// report.
struct Ordered<'a> {
    value: &'a Value,
    /// The required properties in order, if `value` maps names to schemas.
    names: Option<&'a [Value]>,
}

impl<'a> Ordered<'a> {
    fn schema(value: &'a Value) -> Self {
        Ordered { value, names: None }
    }

    /// Returns the position of a key of this object; keys of equal position are in alphabetical order.
    fn position(&self, key: &str) -> usize {
        const KEYWORDS: [&str; 8] =
            ["$schema", "title", "description", "$ref", "const", "type", "properties", "required"];
        match self.names {
            Some(names) => names.iter().position(|name| name == key).unwrap_or(names.len()),
            None if key == "$defs" => usize::MAX,
            None => KEYWORDS.iter().position(|keyword| *keyword == key).unwrap_or(KEYWORDS.len()),
        }
    }
}

impl Serialize for Ordered<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let object = match self.value {
            Value::Object(object) => object,
            Value::Array(items) => return to.collect_seq(items.iter().map(Ordered::schema)),
            other => return other.serialize(to),
        };
        let required = object.get("required").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
        let mut entries: Vec<(&String, &Value)> = object.iter().collect();
        entries.sort_by_key(|(key, _)| self.position(key));
        to.collect_map(entries.into_iter().map(|(key, value)| {
            let names = match key.as_str() {
                "properties" | "$defs" if self.names.is_none() => Some(required),
                _ => None,
            };
            (key, Ordered { value, names })
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn descriptions_have_no_links() {
        for (doc, text) in [
            ("`None` if\n not counted.", "`null` if not counted."),
            ("See [`Figure::as_printed`], [`of`](Self::of).", "See `as_printed`, `of`."),
            ("A [chain](crate::cost) of ranks in [0, 1].", "A chain of ranks in [0, 1]."),
        ] {
            assert_eq!(plain(doc), text);
        }
    }
}
