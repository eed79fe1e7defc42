//! JSON Schemas of the options in a report, from their rows.

use schemars::{Schema, json_schema};
use serde_json::{Map, Value, json};

use septet_core::Door;
use septet_core::spec::Row;

/// The fields of an object, by name.
#[derive(Default)]
pub(crate) struct Fields(Map<String, Value>);

impl Fields {
    /// Adds a field for each row: its types ([`septet_core::spec::Value::TYPES`]) and the first sentence of its document.
    pub(crate) fn and<S: 'static>(mut self, rows: impl IntoIterator<Item = &'static Row<S>>) -> Self {
        for row in rows {
            let first = row.doc.split("\n\n").next().unwrap_or_default();
            // Readers and writers know the formats.
            let first = Door::Rust.spell(&first.replace(" ({data})", ""));
            let description = format!("{}.", first.trim_end_matches('.'));
            self.0.insert(row.key.to_owned(), json!({ "description": description, "type": row.types }));
        }
        self
    }

    /// Returns the schema of an object with these fields.
    pub(crate) fn object(self) -> Schema {
        let required: Vec<&String> = self.0.keys().collect();
        json_schema!({ "type": "object", "properties": self.0, "required": required })
    }
}
