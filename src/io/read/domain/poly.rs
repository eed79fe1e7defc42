//! `.poly` files of `TetGen` (space) and Triangle (plane), and `.smesh` files of `TetGen`.
//!
//! A file has four parts: points, facets (segments in the plane), holes, and regions. The points have the form of a
//! `.node` file, or are in the `.node` file next to it. Ids start at 0 or 1, like those of the points. Comments begin
//! with `#`.

use glam::{DVec2, DVec3};
use septet_geometry::point::Point;
use septet_meshing::input::{DomainKind, Input, InputFacet, InputSegment, Region};

use super::super::error::{InputError, Place};
use super::super::load::{self, Packing};
use super::super::points::ReadProgress;
use super::super::text::{Line, Lines, Source, Words, integer, number};
use super::any::{AnyInput, DomainFile};
use crate::ending::without_gz;

/// The syntax of the list of facets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Facets {
    /// `.poly`: each facet has polygons and holes.
    Polygons,
    /// `.smesh`: one polygon per facet, without holes.
    Simple,
}

const HEADER: &str = "the header `points dimension attributes marker`";

/// Reads the first line: the numbers of points, dimensions, attributes and markers.
fn header(source: Source<'_>, lines: &mut Lines<'_>) -> Result<[u64; 4], InputError> {
    let line = lines.next_data().ok_or_else(|| source.truncated(Place::Line(1), "header line", 1, 0))?;
    let mut words = line.words();
    let count = source.count(&line, words.next(), HEADER)?;
    let mut rest = [3, 0, 0];
    for slot in &mut rest {
        if let Some(word) = words.next() {
            *slot = source.count(&line, Some(word), HEADER)?;
        }
    }
    if !(2..=3).contains(&rest[0]) {
        let (path, place) = (source.path.to_owned(), line.place());
        return Err(InputError::UnsupportedDimension { path, place, found: rest[0] });
    }
    Ok([count, rest[0], rest[1], rest[2]])
}

/// Reads a `.poly` file, and the `.node` file next to it if it has no points.
pub fn read_polygons(source: Source<'_>, progress: &mut ReadProgress<'_>) -> Result<DomainFile, InputError> {
    read_with_node(source, Facets::Polygons, progress)
}

/// Reads a `.smesh` file, and the `.node` file next to it if it has no points.
pub fn read_simple(source: Source<'_>, progress: &mut ReadProgress<'_>) -> Result<DomainFile, InputError> {
    read_with_node(source, Facets::Simple, progress)
}

fn read_with_node(
    source: Source<'_>,
    facets: Facets,
    progress: &mut ReadProgress<'_>,
) -> Result<DomainFile, InputError> {
    let has_points = header(source, &mut Lines::new(source.data))?[0] > 0;
    if has_points {
        return read(source, None, facets);
    }
    let path = without_gz(source.path).0.with_extension("node");
    let data = load::load(&path, Packing::of(&path), progress)?;
    read(source, Some(Source { path: &path, data: &data }), facets)
}

/// Reads a domain. `node` is the `.node` file, if the points are in a separate file.
fn read(source: Source<'_>, node: Option<Source<'_>>, facets: Facets) -> Result<DomainFile, InputError> {
    let mut lines = Lines::new(source.data);
    let mut own = header(source, &mut lines)?;
    let mut reader = Reader { source, lines, first: 0, count: 0 };
    if let Some(node) = node {
        let mut lines = Lines::new(node.data);
        own = header(node, &mut lines)?;
        let beside = Reader { source: node, lines, first: 0, count: 0 };
        return if own[1] == 2 {
            reader.finish(beside.with_points::<DVec2>(own)?, AnyInput::Plane, Reader::segments)
        } else {
            let rest = |r: &mut Reader<'_>, i: &mut Input<DVec3>| r.facets(i, facets);
            reader.finish(beside.with_points::<DVec3>(own)?, AnyInput::Space, rest)
        };
    }
    if own[1] == 2 {
        let points = reader.points::<DVec2>(own)?;
        reader.finish(points, AnyInput::Plane, Reader::segments)
    } else {
        let points = reader.points::<DVec3>(own)?;
        reader.finish(points, AnyInput::Space, |r, i| r.facets(i, facets))
    }
}

/// The points, and the id of the first one.
type Listed<P> = (Input<P>, u64);

struct Reader<'a> {
    source: Source<'a>,
    lines: Lines<'a>,
    /// The id of the first point.
    first: u64,
    /// The number of points.
    count: u64,
}

impl<'a> Reader<'a> {
    fn with_points<P: Point>(mut self, header: [u64; 4]) -> Result<Listed<P>, InputError> {
        self.points(header)
    }

    /// Returns the next line of a list of `of` entries, of which `found` were read.
    fn next(&mut self, what: &'static str, of: u64, found: u64) -> Result<Line<'a>, InputError> {
        let end = self.lines.number();
        self.lines.next_data().ok_or_else(|| self.source.truncated(Place::Line(end), what, of, found))
    }

    /// Reads the count at the start of a part. Returns the count, its line and the words after it, or `None` at the end
    /// of the file.
    fn part(&mut self, what: &str) -> Result<Option<(u64, Line<'a>, Words<'a>)>, InputError> {
        let Some(line) = self.lines.next_data() else { return Ok(None) };
        let mut words = line.words();
        let count = self.source.count(&line, words.next(), what)?;
        Ok(Some((count, line, words)))
    }

    fn real(&self, line: &Line<'_>, word: Option<&[u8]>, what: &str) -> Result<f64, InputError> {
        let word = word.ok_or_else(|| self.source.bad_line(line, what))?;
        let value = number(word).filter(|v| v.is_finite());
        // Adding zero converts -0.0 to 0.0.
        value.map(|v| v + 0.0).ok_or_else(|| self.source.bad_word(line, word, "a finite number"))
    }

    fn at<P: Point>(&self, line: &Line<'_>, words: &mut Words<'_>) -> Result<P, InputError> {
        let mut p = P::splat(0.0);
        for i in 0..P::DIM {
            p.set_coord(i, self.real(line, words.next(), "an id and coordinates")?);
        }
        Ok(p)
    }

    /// Parses a marker. A missing marker is 0.
    fn marker(&self, line: &Line<'_>, word: Option<&[u8]>) -> Result<i64, InputError> {
        word.map_or(Ok(0), |w| {
            integer(w).ok_or_else(|| self.source.bad_word(line, w, "the marker: a whole number"))
        })
    }

    fn points<P: Point>(&mut self, header: [u64; 4]) -> Result<Listed<P>, InputError> {
        let [count, _, attributes, markers] = header;
        if count == 0 || count > u64::from(u32::MAX) {
            return Err(self.source.unsupported(
                Place::Line(self.lines.number()),
                format!("a domain of {count} points"),
                "give between 1 and 4294967295 points",
            ));
        }
        let (mut points, mut marks) = (Vec::new(), Vec::new());
        for found in 0..count {
            let line = self.next("points", count, found)?;
            let mut words = line.words();
            let word = words.next().unwrap_or_default();
            let id = integer(word).and_then(|id| u64::try_from(id).ok());
            if found == 0 {
                self.first = u64::from(id == Some(1));
            }
            if id != Some(self.first + found) {
                let expected = format!("the point id {}, ids consecutive from 0 or 1", self.first + found);
                return Err(self.source.bad_word(&line, word, expected));
            }
            points.push(self.at::<P>(&line, &mut words)?);
            if markers > 0 {
                marks.push(self.marker(&line, words.nth(attributes as usize))?);
            }
        }
        self.count = count;
        Ok((Input { markers: marks, ..Input::new(DomainKind::Complex, points) }, self.first))
    }

    /// Reads the parts after the points.
    fn finish<P: Point>(
        mut self,
        (mut input, first): Listed<P>,
        any: impl FnOnce(Input<P>) -> AnyInput,
        pieces: impl FnOnce(&mut Self, &mut Input<P>) -> Result<(), InputError>,
    ) -> Result<DomainFile, InputError> {
        (self.first, self.count) = (first, input.points.len() as u64);
        pieces(&mut self, &mut input)?;
        self.holes_and_regions(&mut input)?;
        if let Some(line) = self.lines.next_data() {
            return Err(self
                .source
                .bad_line(&line, "the end of the file after points, facets, holes and regions"));
        }
        Ok(DomainFile { input: any(input), notes: Vec::new(), first_id: first })
    }

    /// Parses a point id as a zero-based index.
    fn id(&self, line: &Line<'_>, word: &[u8]) -> Result<u32, InputError> {
        let id =
            integer(word).and_then(|id| u64::try_from(id).ok()).and_then(|id| id.checked_sub(self.first));
        let expected = || format!("a point id from {} to {}", self.first, self.first + self.count - 1);
        let id =
            id.filter(|&id| id < self.count).ok_or_else(|| self.source.bad_word(line, word, expected()))?;
        Ok(id as u32)
    }

    fn segments(&mut self, input: &mut Input<DVec2>) -> Result<(), InputError> {
        const SEGMENT: &str = "a segment `id end end [marker]`";
        let Some((count, ..)) = self.part("the number of segments")? else { return Ok(()) };
        for found in 0..count {
            let line = self.next("segments", count, found)?;
            let mut words = line.words().skip(1);
            let mut end = || words.next().ok_or_else(|| self.source.bad_line(&line, SEGMENT));
            let ends = [self.id(&line, end()?)?, self.id(&line, end()?)?];
            input.segments.push(InputSegment { ends, marker: self.marker(&line, words.next())? });
        }
        Ok(())
    }

    fn facets(&mut self, input: &mut Input<DVec3>, facets: Facets) -> Result<(), InputError> {
        let Some((count, ..)) = self.part("the number of facets")? else { return Ok(()) };
        for found in 0..count {
            let line = self.next("facets", count, found)?;
            input.facets.push(match facets {
                Facets::Simple => {
                    let (polygon, marker) = self.polygon(line)?;
                    InputFacet { polygons: vec![polygon], holes: Vec::new(), marker }
                }
                Facets::Polygons => self.facet(line)?,
            });
        }
        Ok(())
    }

    /// Reads a facet: `polygons [holes [marker]]`, then the polygons, then the holes.
    fn facet(&mut self, line: Line<'a>) -> Result<InputFacet<DVec3>, InputError> {
        const FACET: &str = "a facet `polygons [holes [marker]]`";
        let mut words = line.words();
        let polygons = self.source.count(&line, words.next(), FACET)?;
        let holes = words.next().map_or(Ok(0), |w| self.source.count(&line, Some(w), FACET))?;
        let marker = self.marker(&line, words.next())?;
        let mut facet = InputFacet { polygons: Vec::new(), holes: Vec::new(), marker };
        for found in 0..polygons {
            let line = self.next("polygons of a facet", polygons, found)?;
            facet.polygons.push(self.polygon(line)?.0);
        }
        for found in 0..holes {
            let line = self.next("holes of a facet", holes, found)?;
            let mut words = line.words();
            words.next();
            facet.holes.push(self.at(&line, &mut words)?);
        }
        Ok(facet)
    }

    /// Reads a polygon: `corners id id …`, which may continue on the next lines, and an optional marker.
    fn polygon(&mut self, mut line: Line<'a>) -> Result<(Vec<u32>, i64), InputError> {
        let mut words = line.words();
        let corners = self.source.count(&line, words.next(), "a polygon `corners id id …`")?;
        let mut polygon = Vec::new();
        while (polygon.len() as u64) < corners {
            if let Some(word) = words.next() {
                polygon.push(self.id(&line, word)?);
            } else {
                line = self.next("corners of a polygon", corners, polygon.len() as u64)?;
                words = line.words();
            }
        }
        let marker = self.marker(&line, words.next())?;
        Ok((polygon, marker))
    }

    fn holes_and_regions<P: Point>(&mut self, input: &mut Input<P>) -> Result<(), InputError> {
        const REGION: &str = "a region `id coordinates attribute [limit]`";
        let Some((holes, ..)) = self.part("the number of holes")? else { return Ok(()) };
        for found in 0..holes {
            let line = self.next("holes", holes, found)?;
            let mut words = line.words();
            words.next();
            input.holes.push(self.at(&line, &mut words)?);
        }
        let Some((regions, ..)) = self.part("the number of regions")? else { return Ok(()) };
        for found in 0..regions {
            let line = self.next("regions", regions, found)?;
            let mut words = line.words();
            words.next();
            let at = self.at(&line, &mut words)?;
            let attribute = self.real(&line, words.next(), REGION)?;
            let limit = words.next().map(|w| self.real(&line, Some(w), REGION)).transpose()?;
            // Zero and negative limits mean no limit.
            input.regions.push(Region { at, attribute, limit: limit.filter(|&l| l > 0.0) });
        }
        Ok(())
    }
}
