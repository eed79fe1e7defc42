//! STL files: facets, whose equal corners are merged.

use std::collections::HashMap;

use crate::read::collect::Collector;
use crate::read::error::{InputError, Place};
use crate::read::faces::Faces;
use crate::read::points::{CoordinateType, PointFile, ReadOptions};
use crate::read::signature::{FACET, HEAD, announced, is_binary};
use crate::read::text::{Line, Lines, Source, excerpt, number};

/// The distinct corners read so far.
struct Welder<'a> {
    points: Collector<'a>,
    seen: HashMap<[u64; 3], u32>,
    corners: u64,
    /// The point of each corner, three per facet.
    facets: Vec<u32>,
    /// The name of each solid, and the number of facets at its end.
    solids: Vec<(String, u32)>,
}

/// Reads the distinct corners of all facets in the order of their first appearance. Indices count distinct corners.
/// Each invalid corner counts separately.
pub fn read(source: Source<'_>, options: &ReadOptions) -> Result<PointFile, InputError> {
    Ok(read_faces(source, options)?.0)
}

/// Solids with the number of facets up to the end of each.
pub type Solids = Vec<(String, u32)>;

/// Reads the distinct corners, the facets and the solids.
pub fn read_faces(
    source: Source<'_>,
    options: &ReadOptions,
) -> Result<(PointFile, Faces, Solids), InputError> {
    let points = Collector::new(source, options, (Place::Whole, 3), (0, 0, 1))?;
    let mut welder =
        Welder { points, seen: HashMap::new(), corners: 0, facets: Vec::new(), solids: Vec::new() };
    let head = source.data.trim_ascii_start();
    let texty = head.get(..5).is_some_and(|w| w.eq_ignore_ascii_case(b"solid"))
        && !source.data[..source.data.len().min(1024)].contains(&0);
    if is_binary(source.data) || !texty {
        read_binary(source, &mut welder)?;
    } else {
        read_ascii(source, &mut welder)?;
    }
    let Welder { mut points, seen, corners, facets, mut solids } = welder;
    if corners == 0 {
        return Err(source.unsupported(Place::Whole, "an STL file without facets", "export it with facets"));
    }
    points.notes.push(format!("{corners} facet corners merged into {} points", seen.len()));
    points.note_if_flat();
    let mut before = 0;
    solids.retain(|(_, end)| std::mem::replace(&mut before, *end) < *end);
    Ok((points.finish(), facets.chunks_exact(3).map(<[u32]>::to_vec).collect(), solids))
}

impl Welder<'_> {
    fn push(&mut self, place: Place, mut at: [f64; 3]) -> Result<(), InputError> {
        self.corners += 1;
        if self.points.dimension() == 2 {
            at[2] = 0.0;
        }
        // Adding zero gives both zeros the same key.
        if at.iter().all(|c| c.is_finite()) {
            let next = self.seen.len() as u32;
            let point = *self.seen.entry(at.map(|c| (c + 0.0).to_bits())).or_insert(next);
            self.facets.push(point);
            if point < next {
                return Ok(());
            }
        }
        self.points.push(place, &at)
    }
}

fn read_binary(source: Source<'_>, welder: &mut Welder<'_>) -> Result<(), InputError> {
    welder.points.coordinate_type = Some(CoordinateType::Float32);
    let data = source.data;
    let size = data.len() as u64;
    let count = announced(data)
        .ok_or_else(|| source.truncated(Place::Byte(size), "header bytes", HEAD as u64, size))?;
    let facets = data[HEAD..].chunks_exact(FACET);
    if (facets.len() as u64) < count {
        return Err(source.truncated(Place::Byte(80), "facets", count, facets.len() as u64));
    }
    let surplus = size - HEAD as u64 - FACET as u64 * count;
    if surplus > 0 {
        welder.points.notes.push(format!("{surplus} bytes after the last facet are ignored"));
    }
    for (i, facet) in facets.take(count as usize).enumerate() {
        // Twelve floats: the normal and three corners.
        for (corner, bytes) in facet[12..48].chunks_exact(12).enumerate() {
            let mut at = [0.0; 3];
            for (c, b) in at.iter_mut().zip(bytes.chunks_exact(4)) {
                *c = f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
            }
            let offset = HEAD + FACET * i + 12 + 12 * corner;
            welder.push(Place::Byte(offset as u64), at)?;
        }
    }
    Ok(())
}

fn read_ascii(source: Source<'_>, welder: &mut Welder<'_>) -> Result<(), InputError> {
    let mut ended = false;
    let mut in_facet = 0;
    let mut lines = Lines::new(source.data);
    for line in lines.by_ref() {
        match line.keyword().as_str() {
            "vertex" => {
                in_facet += 1;
                push_vertex(source, welder, &line)?;
            }
            "endfacet" => {
                if in_facet != 3 {
                    return Err(source.truncated(line.place(), "corners of a facet", 3, in_facet));
                }
                in_facet = 0;
                let end = welder.facets.len() as u32 / 3;
                if let Some(solid) = welder.solids.last_mut() {
                    solid.1 = end;
                }
            }
            "endsolid" => ended = true,
            "solid" => {
                let name = line.text.trim_ascii_start().get(5..).unwrap_or_default().trim_ascii();
                welder.solids.push((excerpt(name), 0));
            }
            "" | "facet" | "outer" | "endloop" | "color" => {}
            _ => {
                return Err(source.bad_line(&line, "a line of an ASCII STL file (solid, facet, vertex, …)"));
            }
        }
    }
    if !ended || in_facet != 0 {
        return Err(source.truncated(Place::Line(lines.number()), "line `endsolid`", 1, 0));
    }
    Ok(())
}

fn push_vertex(source: Source<'_>, welder: &mut Welder<'_>, line: &Line<'_>) -> Result<(), InputError> {
    let mut at = [0.0; 3];
    let mut words = line.words().skip(1);
    for (found, slot) in at.iter_mut().enumerate() {
        let Some(word) = words.next() else {
            return Err(source.bad_line(line, format!("three coordinates after `vertex`, not {found}")));
        };
        let Some(value) = number(word) else {
            welder.corners += 1;
            return welder.points.malformed(line, word);
        };
        *slot = value;
    }
    if words.next().is_some() {
        return Err(source.bad_line(line, "three coordinates after `vertex`, no more"));
    }
    welder.push(line.place(), at)
}
