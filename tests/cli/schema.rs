//! The JSON schemas, and the reports that they describe.

use super::*;

/// The part of JSON Schema that the schemas of septet use.
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
        if let Some(reference) = schema["$ref"].as_str() {
            let name = reference.strip_prefix("#/$defs/").unwrap();
            self.matches(&self.0["$defs"][name], value, at)?;
        }
        for key in ["anyOf", "oneOf"] {
            if let Some(alternatives) = schema[key].as_array() {
                let fits = alternatives.iter().filter(|s| self.matches(s, value, at).is_ok()).count();
                if fits == 0 || key == "oneOf" && fits > 1 {
                    return Err(format!("{at}: {fits} of {key} match {value}"));
                }
            }
        }
        let expected = schema.get("const").is_none_or(|c| c == value)
            && schema["enum"].as_array().is_none_or(|all| all.contains(value))
            && (schema["minimum"].is_null() || value.as_i64().is_none_or(|n| n >= 0))
            && is_of_type(&schema["type"], value);
        if !expected {
            return Err(format!("{at}: unexpected {value}"));
        }
        self.parts(schema, value, at)
    }

    /// Checks the fields of an object and the items of an array.
    fn parts(&self, schema: &Value, value: &Value, at: &str) -> Result<(), String> {
        if let (Some(properties), Some(object)) = (schema["properties"].as_object(), value.as_object()) {
            for required in schema["required"].as_array().into_iter().flatten() {
                let name = required.as_str().unwrap();
                object.get(name).ok_or_else(|| format!("{at}: no field `{name}`"))?;
            }
            for (name, field) in object {
                let schema = properties.get(name).ok_or_else(|| format!("{at}: unknown field `{name}`"))?;
                self.matches(schema, field, &format!("{at}/{name}"))?;
            }
        }
        for (i, item) in value.as_array().into_iter().flatten().enumerate() {
            let schema =
                if schema["prefixItems"].is_array() { &schema["prefixItems"][i] } else { &schema["items"] };
            self.matches(schema, item, &format!("{at}/{i}"))?;
        }
        Ok(())
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
