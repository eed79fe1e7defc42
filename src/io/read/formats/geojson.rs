//! `GeoJSON` (RFC 7946): polygons, lines and points of features.

use glam::DVec2;
use septet_meshing::plane::Polygon;
use serde_json::{Map, Value};

use super::super::domain::{DomainFile, MapFile};
use super::super::error::{InputError, Place};
use super::super::points::ReadProgress;
use super::super::text::Source;

type Object = Map<String, Value>;

/// Reads a domain.
pub fn read_domain(source: Source<'_>, _: &mut ReadProgress<'_>) -> Result<DomainFile, InputError> {
    read(source).map(MapFile::into_domain)
}

/// Reads the shapes.
pub fn read(source: Source<'_>) -> Result<MapFile, InputError> {
    let data = source.data.strip_prefix(b"\xef\xbb\xbf").unwrap_or(source.data);
    let value: Value = serde_json::from_slice(data).map_err(|error| InputError::Syntax {
        path: source.path.to_owned(),
        line: error.line() as u64,
        column: u32::try_from(error.column()).ok(),
        text: error.to_string().into(),
        expected: "JSON".into(),
        row: None,
        columns: None,
    })?;
    let mut reader = Reader { source, map: MapFile::default() };
    reader.top(&value)?;
    Ok(reader.map)
}

/// Whether the data are a `GeoJSON` object: a brace, and the name of a type near the beginning.
pub fn is_geojson(data: &[u8]) -> bool {
    const HEAD: usize = 4096;
    let head = &data[..data.len().min(HEAD)];
    let has = |word: &[u8]| head.windows(word.len()).any(|w| w == word);
    data.first() == Some(&b'{')
        && [&b"\"FeatureCollection\""[..], b"\"Feature\"", b"\"coordinates\"", b"\"GeometryCollection\""]
            .into_iter()
            .any(has)
}

struct Reader<'a> {
    source: Source<'a>,
    map: MapFile,
}

impl Reader<'_> {
    fn bad(&self, what: impl Into<String>, advice: &str) -> InputError {
        let feature = self.map.shapes.features;
        let what = what.into();
        let what = if feature == 0 { what } else { format!("feature {feature} with {what}") };
        self.source.unsupported(Place::Whole, what, advice)
    }

    fn object<'v>(&self, value: &'v Value, what: &str) -> Result<(&'v Object, &'v str), InputError> {
        let object = value.as_object();
        let kind = object.and_then(|o| o.get("type")).and_then(Value::as_str);
        object.zip(kind).ok_or_else(|| self.bad(format!("{what} without a type"), "give GeoJSON of RFC 7946"))
    }

    fn top(&mut self, value: &Value) -> Result<(), InputError> {
        let (object, kind) = self.object(value, "a file")?;
        if let Some(system) = object.get("crs").filter(|crs| !crs.is_null()) {
            let name = system.pointer("/properties/name").and_then(Value::as_str);
            self.map.system = Some(name.unwrap_or("of the member crs").to_owned());
        }
        match kind {
            "FeatureCollection" => {
                let list = object.get("features").and_then(Value::as_array);
                let list =
                    list.ok_or_else(|| self.bad("a collection without features", "add its features"))?;
                list.iter().try_for_each(|feature| self.feature(feature))
            }
            "Feature" => self.feature(value),
            _ => {
                self.map.shapes.features = 1;
                self.geometry(value)
            }
        }
    }

    fn feature(&mut self, value: &Value) -> Result<(), InputError> {
        self.map.shapes.features += 1;
        let (object, kind) = self.object(value, "an element")?;
        if kind != "Feature" {
            return Err(self.bad(format!("the type {kind}"), "a collection of features holds features only"));
        }
        let properties = object.get("properties").and_then(Value::as_object);
        self.map.has_properties |= properties.is_some_and(|p| !p.is_empty());
        match object.get("geometry") {
            None | Some(Value::Null) => {
                self.map.empty += 1;
                Ok(())
            }
            Some(geometry) => self.geometry(geometry),
        }
    }

    fn geometry(&mut self, value: &Value) -> Result<(), InputError> {
        let (object, kind) = self.object(value, "a geometry")?;
        let member = if kind == "GeometryCollection" { "geometries" } else { "coordinates" };
        let list = object.get(member).and_then(Value::as_array);
        let list = list.ok_or_else(|| self.bad(format!("a {kind} without {member}"), "add them"))?;
        match kind {
            "Polygon" => self.polygon(list),
            "MultiPolygon" => {
                list.iter().try_for_each(|p| self.list(p).and_then(|rings| self.polygon(rings)))
            }
            "LineString" => self.line(list),
            "MultiLineString" => list.iter().try_for_each(|l| self.list(l).and_then(|line| self.line(line))),
            "Point" => self.position(list).map(|_| ()),
            "MultiPoint" => self.positions(list).map(|_| ()),
            "GeometryCollection" => list.iter().try_for_each(|geometry| self.geometry(geometry)),
            _ => Err(self.bad(format!("the type {kind}"), "give polygons, lines or points")),
        }
    }

    fn list<'v>(&self, value: &'v Value) -> Result<&'v [Value], InputError> {
        let list = value.as_array().map(Vec::as_slice);
        list.ok_or_else(|| self.bad("coordinates that are not a list", "give GeoJSON of RFC 7946"))
    }

    fn position(&mut self, words: &[Value]) -> Result<u32, InputError> {
        let number = |i: usize| words.get(i).and_then(Value::as_f64).filter(|x| x.is_finite());
        match (number(0), number(1)) {
            (Some(x), Some(y)) => Ok(self.map.shapes.push(DVec2::new(x, y), number(2))),
            _ => Err(self.bad("a position without two numbers", "a position is [x, y] or [x, y, z]")),
        }
    }

    fn positions(&mut self, list: &[Value]) -> Result<Vec<u32>, InputError> {
        let mut all = Vec::with_capacity(list.len());
        for value in list {
            let words = self.list(value)?;
            all.push(self.position(words)?);
        }
        Ok(all)
    }

    fn line(&mut self, list: &[Value]) -> Result<(), InputError> {
        let line = self.positions(list)?;
        let feature = self.map.shapes.features;
        self.map.shapes.lines.push((feature, line));
        Ok(())
    }

    fn polygon(&mut self, list: &[Value]) -> Result<(), InputError> {
        let mut rings = Vec::with_capacity(list.len());
        for value in list {
            let ring = self.list(value)?;
            let ring = self.positions(ring)?;
            self.map.close(&ring);
            rings.push(ring);
        }
        self.map.shapes.polygons.push(Polygon { feature: self.map.shapes.features, rings });
        Ok(())
    }
}
