//! The JSON schemas, and the reports that they describe.

use super::*;

/// All schemas, by name.
const NAMES: [&str; 10] =
    ["run", "mesh", "scale", "fit", "speedup", "claims", "predict", "rival", "verify", "cost"];

/// A JSON Schema with the keywords that the schemas of septet use. Another keyword is an error. `tests/foreign` compares with a
/// validator of all of JSON Schema.
struct Schema(Value);

impl Schema {
    fn of(place: &Place, name: &str) -> Self {
        Schema(serde_json::from_slice(&place.good(&format!("schema {name}")).stdout).unwrap())
    }

    /// Panics with the path of a value that does not match.
    fn check(&self, what: &str, value: &Value) {
        if let Err(error) = self.matches(&self.0, value, "") {
            panic!("{what}: {error}");
        }
    }

    fn matches(&self, schema: &Value, value: &Value, at: &str) -> Result<(), String> {
        let Value::Object(keywords) = schema else { panic!("{at}: the schema is {schema}") };
        keywords.iter().try_for_each(|(keyword, rule)| self.obeys(keyword, rule, schema, value, at))
    }

    fn obeys(
        &self,
        keyword: &str,
        rule: &Value,
        schema: &Value,
        value: &Value,
        at: &str,
    ) -> Result<(), String> {
        let list = || rule.as_array().unwrap().iter();
        let object = || value.as_object().into_iter().flatten();
        let items = || value.as_array().into_iter().flatten().enumerate();
        let known = |name: &str| schema["properties"].get(name).is_some();
        let length = value.as_array().map(|items| items.len() as u64);
        let holds = match keyword {
            "$schema" | "title" | "description" | "$defs" => true,
            "$ref" => {
                let name = rule.as_str().unwrap().strip_prefix("#/$defs/").unwrap();
                return self.matches(&self.0["$defs"][name], value, at);
            }
            "anyOf" => list().any(|one| self.matches(one, value, at).is_ok()),
            "oneOf" => list().filter(|one| self.matches(one, value, at).is_ok()).count() == 1,
            "const" => rule == value,
            "enum" => list().any(|one| one == value),
            "type" => is_of_type(rule, value),
            "minimum" => value.as_f64().is_none_or(|number| number >= rule.as_f64().unwrap()),
            "maximum" => value.as_f64().is_none_or(|number| number <= rule.as_f64().unwrap()),
            "minItems" => length.is_none_or(|length| length >= rule.as_u64().unwrap()),
            "maxItems" => length.is_none_or(|length| length <= rule.as_u64().unwrap()),
            "required" => {
                let missing =
                    |name: &&Value| value.is_object() && value.get(name.as_str().unwrap()).is_none();
                return list().find(missing).map_or(Ok(()), |name| Err(format!("{at}: no field `{name}`")));
            }
            "properties" => {
                return object().filter(|(name, _)| known(name)).try_for_each(|(name, field)| {
                    self.matches(&rule[name.as_str()], field, &format!("{at}/{name}"))
                });
            }
            "additionalProperties" => {
                return object().filter(|(name, _)| !known(name)).try_for_each(|(name, field)| match rule {
                    Value::Bool(false) => Err(format!("{at}: unknown field `{name}`")),
                    rule => self.matches(rule, field, &format!("{at}/{name}")),
                });
            }
            "prefixItems" => {
                let pairs = list().zip(items());
                return pairs
                    .into_iter()
                    .try_for_each(|(rule, (i, item))| self.matches(rule, item, &format!("{at}/{i}")));
            }
            "items" => {
                return items().try_for_each(|(i, item)| self.matches(rule, item, &format!("{at}/{i}")));
            }
            other => panic!("{at}: the keyword `{other}`"),
        };
        if holds { Ok(()) } else { Err(format!("{at}: {keyword} {rule} does not allow {value}")) }
    }
}

/// Returns all schemas within a schema, with their paths.
fn parts<'a>(schema: &'a Value, at: &str, found: &mut Vec<(String, &'a Value)>) {
    found.push((at.to_owned(), schema));
    for (keyword, rule) in schema.as_object().into_iter().flatten() {
        let inner = match (keyword.as_str(), rule) {
            ("properties" | "$defs", Value::Object(named)) => {
                named.iter().map(|(name, one)| (name.clone(), one)).collect()
            }
            ("anyOf" | "oneOf" | "prefixItems", Value::Array(list)) => {
                list.iter().enumerate().map(|(i, one)| (i.to_string(), one)).collect()
            }
            ("items" | "additionalProperties", Value::Object(_)) => vec![(String::new(), rule)],
            _ => Vec::new(),
        };
        for (name, one) in inner {
            parts(one, &format!("{at}/{keyword}/{name}"), found);
        }
    }
}

#[test]
fn every_field_is_described_and_every_object_is_closed() {
    let place = Place::new();
    for name in NAMES {
        let Schema(schema) = Schema::of(&place, name);
        assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema", "{name}");
        assert!(schema["title"].as_str().is_some_and(|title| title.contains("septet")), "{name}");
        let mut all = Vec::new();
        parts(&schema, name, &mut all);
        let described = |one: &Value| one["description"].as_str().is_some_and(|text| text.ends_with('.'));
        for (at, part) in all {
            for (field, one) in part["properties"].as_object().into_iter().flatten() {
                assert!(described(one), "{at}: {field}: {one}");
                let text = one["description"].as_str().unwrap_or_default();
                assert!(!text.contains("`None`") && !text.contains("[`"), "{at}: {field}: {text}");
            }
            if part.get("properties").is_some() {
                assert_eq!(part["additionalProperties"], false, "{at}");
                assert!(part["required"].is_array() && described(part), "{at}");
            }
        }
    }
}

fn is_of_type(types: &Value, value: &Value) -> bool {
    let is = |name: &Value| match name.as_str().unwrap() {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_u64() || value.is_i64(),
        "number" => value.is_number(),
        "null" => value.is_null(),
        other => panic!("type {other}"),
    };
    match types {
        Value::Null => true,
        Value::Array(all) => all.iter().any(is),
        one => is(one),
    }
}

#[test]
fn reports_of_runs_match_their_schema() {
    let place = Place::new();
    let schema = Schema::of(&place, "run");
    for line in [
        "triangulate sample:uniform:500 --workers 2",
        "simulate sample:clusters:800 --workers 3 --leaf 50 --view 100",
        "simulate sample:uniform:300,d=2 --supergraph knn --workers leaves",
        "simulate sample:uniform:300 --nodes none",
        "triangulate sample:uniform:0",
    ] {
        place.good(&format!("{line} --json r.json"));
        schema.check(line, &place.json("r.json"));
    }
    place.run("simulate sample:uniform:500 --fault spoil:1 --json r.json");
    schema.check("an uncertified run", &place.json("r.json"));
    place.good("predict sample:uniform:800 --workers 1,2,48 --json p.json");
    Schema::of(&place, "predict").check("predict", &place.json("p.json"));
}

#[test]
fn reports_of_meshes_match_their_schema() {
    let place = Place::new();
    let schema = Schema::of(&place, "mesh");
    for name in ["cube.poly", "cube.stl", "map.poly"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/domains/good").join(name);
        place.good(&format!("mesh {} --size 1 --json m.json", path.display()));
        schema.check(name, &place.json("m.json"));
    }
}

#[test]
fn sweeps_and_fits_match_their_schemas() {
    let place = Place::new();
    place.good("scale -n 256,362,512,724,1024 --seeds 2 -d 2 --until partition -o r.jsonl");
    place.good("scale -n 256,512 --seeds 2 -d 2 --timed --workers 1,2 -o t.jsonl");
    let schema = Schema::of(&place, "scale");
    for file in ["r.jsonl", "t.jsonl"] {
        for line in fs::read_to_string(place.path(file)).unwrap().lines() {
            schema.check(file, &serde_json::from_str(line).unwrap());
        }
    }
    place.good("fit r.jsonl -y levels --json f.json");
    place.good("fit t.jsonl --speedup --json s.json");
    Schema::of(&place, "fit").check("fit", &place.json("f.json"));
    Schema::of(&place, "speedup").check("speedup", &place.json("s.json"));
    let list = String::from_utf8(place.good("fit r.jsonl").stdout).unwrap();
    assert!(list.contains("-y") && list.contains("max-degree") && list.contains("partition"), "{list}");
}

#[test]
fn cost_traces_match_their_schema() {
    let place = Place::new();
    let schema = Schema::of(&place, "cost");
    let mut nested = 0;
    for line in [
        "simulate sample:clusters:800 --workers 3 --leaf 60",
        "simulate sample:uniform:400,d=2 --neighbours naive --constants timing --leaf 60",
        "simulate sample:uniform:400 --supergraph knn --fault work:hulls:2",
    ] {
        place.good(&format!("{line} --cost-trace c.jsonl"));
        let text = fs::read_to_string(place.path("c.jsonl")).unwrap();
        let rows: Vec<Value> = text.lines().map(|row| serde_json::from_str(row).unwrap()).collect();
        for row in &rows {
            schema.check(line, row);
        }
        nested += rows.iter().filter(|row| row["longest"].is_array()).count();
        let mut other = rows[1].clone();
        other["work"] = 1.into();
        assert!(schema.matches(&schema.0, &other, "").is_err(), "{line}: an unknown field");
        let mut header = rows[0].clone();
        header.as_object_mut().unwrap().remove("samples");
        assert!(schema.matches(&schema.0, &header, "").is_err(), "{line}: a header without samples");
    }
    assert!(nested > 10, "{nested}");
}

#[test]
fn other_reports_match_their_schemas() {
    let place = Place::new();
    place.file("p.xyz", "0 0\n2 0\n0 1\n3 3\n").file("bad.ele", "2 3 0\n0 0 1 3\n1 0 3 2\n");
    place.run("verify p.xyz bad.ele --json v.json");
    Schema::of(&place, "verify").check("verify", &place.json("v.json"));
    place.good("rival incremental -n 300 --kind uniform --against --json b.json");
    Schema::of(&place, "rival").check("rival", &place.json("b.json"));
    place.good("reproduce separator-attempts ply --json c.json");
    Schema::of(&place, "claims").check("claims", &place.json("c.json"));
}

#[test]
fn a_planted_field_does_not_match() {
    let place = Place::new();
    place.good("triangulate sample:uniform:100 --json r.json");
    let schema = Schema::of(&place, "run");
    let mut report = place.json("r.json");
    report["machine"]["speed"] = 1.into();
    assert!(schema.matches(&schema.0, &report, "").unwrap_err().contains("unknown field `speed`"));
    let mut report = place.json("r.json");
    report["simplices"] = "many".into();
    assert!(schema.matches(&schema.0, &report, "").unwrap_err().contains("/simplices"));
}
