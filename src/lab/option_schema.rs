//! JSON Schemas of the options in a report, from their rows.

use schemars::{Schema, json_schema};
use serde_json::{Map, Value, json};

use septet_core::Spec;
use septet_core::spec::{Row, Setting, row as row_of};

/// Returns the schema of an object with a field for each row.
pub(crate) fn object<'a>(rows: impl Iterator<Item = &'a Row>) -> Schema {
    let fields: Map<String, Value> = rows.map(|row| (row.key.to_owned(), value(row))).collect();
    let required: Vec<&String> = fields.keys().collect();
    json_schema!({ "type": "object", "properties": fields, "required": required })
}

/// Returns the schema of an option: the types of its default and of the values that it accepts from samples of all kinds.
fn value(row: &Row) -> Value {
    let mut settings = vec![row.get(&Spec::default())];
    let samples = ["2", "auto", "0.5", "1,2,3", "f64,3", "xyz"];
    for sample in samples.into_iter().chain(row.words.iter().map(|&(word, _)| word)) {
        let mut spec = Spec::default();
        let needed = row.needs.map(|(option, word)| row_of(option).set(&mut spec, word));
        if needed.is_none_or(|set| set.is_ok()) && row.set(&mut spec, sample).is_ok() {
            settings.push(row.get(&spec));
        }
    }
    let is_any = |kind: fn(&Setting) -> bool| settings.iter().any(kind);
    let types = [
        ("boolean", is_any(|value| matches!(value, Setting::Flag(_)))),
        ("integer", is_any(|value| matches!(value, Setting::Number(_)))),
        ("string", is_any(|value| matches!(value, Setting::Text(_)))),
        ("array", is_any(|value| matches!(value, Setting::List(_)))),
        ("null", is_any(|value| matches!(value, Setting::None))),
    ];
    let types: Vec<&str> = types.into_iter().filter(|(_, occurs)| *occurs).map(|(name, _)| name).collect();
    let first = row.doc.split("\n\n").next().unwrap_or_default();
    json!({ "description": format!("{}.", first.trim_end_matches('.')), "type": types })
}
