//! Well-known text: polygons, lines and points. Each geometry of the file is a feature.

use glam::DVec2;
use septet_meshing::plane::Polygon;

use super::super::domain::{DomainFile, MapFile};
use super::super::error::InputError;
use super::super::points::ReadProgress;
use super::super::text::{Source, excerpt, number};

/// Reads a domain.
pub fn read_domain(source: Source<'_>, _: &mut ReadProgress<'_>) -> Result<DomainFile, InputError> {
    read(source).map(MapFile::into_domain)
}

/// Reads the shapes.
pub fn read(source: Source<'_>) -> Result<MapFile, InputError> {
    let data = source.data.strip_prefix(b"\xef\xbb\xbf").unwrap_or(source.data);
    let at = source.data.len() - data.len();
    let mut reader = Reader { source, at, depth: 0, map: MapFile::default() };
    while reader.peek().is_some() {
        reader.map.shapes.features += 1;
        reader.system()?;
        reader.geometry()?;
        while matches!(reader.peek(), Some(b';' | b',')) {
            reader.at += 1;
        }
    }
    Ok(reader.map)
}

/// The words with which a geometry begins.
const KINDS: [&str; 7] =
    ["POLYGON", "MULTIPOLYGON", "LINESTRING", "MULTILINESTRING", "POINT", "MULTIPOINT", "GEOMETRYCOLLECTION"];

/// The largest number of collections inside each other. JSON has a similar limit.
const DEEPEST: usize = 100;

/// Whether the data begin with a geometry. The header row of a table may begin with the same word.
pub fn is_wkt(data: &[u8]) -> bool {
    let (kind, rest) = first_word(data);
    let (axes, after) = first_word(rest);
    let is_axes = ["z", "m", "zm"].iter().any(|word| axes.eq_ignore_ascii_case(word.as_bytes()));
    let rest = if is_axes { after } else { rest };
    let is_body = rest.starts_with(b"(") || first_word(rest).0.eq_ignore_ascii_case(b"empty");
    is_body && KINDS.iter().any(|known| kind.eq_ignore_ascii_case(known.as_bytes()))
        || data.len() > 5 && data[..5].eq_ignore_ascii_case(b"SRID=")
}

/// Returns the letters at the beginning, and what follows after blanks.
fn first_word(data: &[u8]) -> (&[u8], &[u8]) {
    let end = data.iter().position(|b| !b.is_ascii_alphabetic()).unwrap_or(data.len());
    let (word, rest) = data.split_at(end);
    (word, rest.trim_ascii_start())
}

/// The coordinates of a position after x and y.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Axes {
    /// Unknown: a third number is a height.
    Unsaid,
    /// A height.
    Z,
    /// A measure, not a height.
    M,
}

struct Reader<'a> {
    source: Source<'a>,
    at: usize,
    /// The number of collections around the position.
    depth: usize,
    map: MapFile,
}

impl Reader<'_> {
    /// Skips blanks and returns the next byte.
    fn peek(&mut self) -> Option<u8> {
        while self.source.data.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
        self.source.data.get(self.at).copied()
    }

    fn bad(&self, expected: &str) -> InputError {
        let rest = &self.source.data[self.at..];
        let rest = rest.split(|b| matches!(b, b'\n' | b'\r')).next().unwrap_or_default();
        let text = if rest.is_empty() { "the end of the line".to_owned() } else { excerpt(rest) };
        self.source.bad_at(self.at, text, expected)
    }

    /// Reads a word of letters, in upper case.
    fn word(&mut self) -> String {
        self.peek();
        let rest = &self.source.data[self.at..];
        let end = rest.iter().position(|b| !b.is_ascii_alphabetic()).unwrap_or(rest.len());
        self.at += end;
        String::from_utf8_lossy(&rest[..end]).to_ascii_uppercase()
    }

    fn has(&mut self, byte: u8) -> bool {
        let is_next = self.peek() == Some(byte);
        self.at += usize::from(is_next);
        is_next
    }

    fn expect(&mut self, byte: u8, expected: &str) -> Result<(), InputError> {
        if self.has(byte) { Ok(()) } else { Err(self.bad(expected)) }
    }

    /// Reads the coordinate system in front of a geometry.
    fn system(&mut self) -> Result<(), InputError> {
        let start = self.at;
        if self.word() != "SRID" {
            self.at = start;
            return Ok(());
        }
        let start = self.at;
        while self.peek().is_some_and(|b| b != b';') {
            self.at += 1;
        }
        let system = String::from_utf8_lossy(&self.source.data[start..self.at]);
        self.map.system = Some(format!("SRID{}", system.trim()));
        self.expect(b';', "`SRID=number;` in front of a geometry")
    }

    fn geometry(&mut self) -> Result<(), InputError> {
        self.peek();
        let start = self.at;
        let mut kind = self.word();
        let mut axes = Axes::Unsaid;
        for (suffix, has) in [("ZM", Axes::Z), ("Z", Axes::Z), ("M", Axes::M)] {
            if let Some(short) = kind.strip_suffix(suffix).filter(|short| KINDS.contains(short)) {
                (kind, axes) = (short.to_owned(), has);
                break;
            }
        }
        if !KINDS.contains(&kind.as_str()) {
            self.at = start;
            return Err(
                self.bad("a polygon, line or point in well-known text, as in POLYGON ((0 0, 1 0, 0 1, 0 0))")
            );
        }
        let start = self.at;
        match self.word().as_str() {
            "Z" | "ZM" => axes = Axes::Z,
            "M" => axes = Axes::M,
            _ => self.at = start,
        }
        self.content(&kind, axes)
    }

    fn content(&mut self, kind: &str, axes: Axes) -> Result<(), InputError> {
        if self.is_empty() {
            self.map.empty += 1;
            return Ok(());
        }
        match kind {
            "POLYGON" => self.polygon(axes),
            "MULTIPOLYGON" => self.members(|r| r.polygon(axes)),
            "LINESTRING" => self.line(axes),
            "MULTILINESTRING" => self.members(|r| r.line(axes)),
            "POINT" => self.positions(axes).map(|_| ()),
            "MULTIPOINT" => self.members(|r| {
                let is_nested = r.has(b'(');
                r.position(axes)?;
                if is_nested { r.expect(b')', "`)` after a point") } else { Ok(()) }
            }),
            _ => self.collection(),
        }
    }

    fn collection(&mut self) -> Result<(), InputError> {
        if self.depth == DEEPEST {
            return Err(self.bad("at most 100 collections inside each other"));
        }
        self.depth += 1;
        self.members(Self::geometry)?;
        self.depth -= 1;
        Ok(())
    }

    /// Reads the word `EMPTY`.
    fn is_empty(&mut self) -> bool {
        let start = self.at;
        let is_empty = self.word() == "EMPTY";
        if !is_empty {
            self.at = start;
        }
        is_empty
    }

    /// Reads members between parentheses, separated by commas.
    fn members(
        &mut self,
        mut member: impl FnMut(&mut Self) -> Result<(), InputError>,
    ) -> Result<(), InputError> {
        self.expect(b'(', "`(`")?;
        loop {
            if !self.is_empty() {
                member(self)?;
            }
            if !self.has(b',') {
                return self.expect(b')', "`,` or `)`");
            }
        }
    }

    fn real(&mut self) -> Option<f64> {
        self.peek();
        let rest = &self.source.data[self.at..];
        let is_part = |b: &u8| b.is_ascii_alphanumeric() || matches!(b, b'.' | b'+' | b'-');
        let end = rest.iter().position(|b| !is_part(b)).unwrap_or(rest.len());
        let value = number(&rest[..end]).filter(|x| x.is_finite())?;
        self.at += end;
        Some(value)
    }

    fn position(&mut self, axes: Axes) -> Result<u32, InputError> {
        let numbers = [(); 4].map(|()| self.real());
        let [Some(x), Some(y), third, _] = numbers else {
            return Err(self.bad("a position of two or three finite numbers"));
        };
        let height = if axes == Axes::M { None } else { third };
        Ok(self.map.shapes.push(DVec2::new(x, y), height))
    }

    fn positions(&mut self, axes: Axes) -> Result<Vec<u32>, InputError> {
        let mut all = Vec::new();
        self.members(|r| {
            all.push(r.position(axes)?);
            Ok(())
        })?;
        Ok(all)
    }

    fn line(&mut self, axes: Axes) -> Result<(), InputError> {
        let line = self.positions(axes)?;
        self.map.shapes.lines.push((self.map.shapes.features, line));
        Ok(())
    }

    fn polygon(&mut self, axes: Axes) -> Result<(), InputError> {
        let mut rings = Vec::new();
        self.members(|r| {
            let ring = r.positions(axes)?;
            r.map.close(&ring);
            rings.push(ring);
            Ok(())
        })?;
        self.map.shapes.polygons.push(Polygon { feature: self.map.shapes.features, rings });
        Ok(())
    }
}
