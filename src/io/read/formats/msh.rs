//! Gmsh `.msh`, versions 2 and 4.1: ASCII here, binary in `binary`.

mod binary;
mod data;
mod parts;

use crate::read::cells::index;
use crate::read::collect::Collector;
use crate::read::error::{InputError, Place};
use crate::read::mesh::{CellKind, FileMesh};
use crate::read::mesh_sizes;
use crate::read::points::ReadOptions;
use crate::read::text::{Line, Lines, Source, integer};
use data::NodeData;
use parts::{ADVICE, Section, Tags, Version, kind, tag};
use septet_core::mesh::field::SizeField;

/// Reads the sizes at the nodes: the data with the name `size`, or the only data.
pub fn read_sizes(source: Source<'_>) -> Result<SizeField, InputError> {
    if is_binary(source) {
        let advice = "save it as text (gmsh -bin 0), or give a .vtu file";
        return Err(source.unsupported(Place::Whole, "a binary .msh file of sizes", advice));
    }
    let mut data = Vec::new();
    let mesh = parse_text(source, &ReadOptions::default(), Some(&mut data))?;
    let only = if let [only] = &data[..] { Some(only) } else { None };
    let Some(found) = data.iter().find(|data| data.name == "size").or(only) else {
        let what = format!("a mesh with {} sections $NodeData of numbers", data.len());
        return Err(source.unsupported(Place::Whole, what, "name the data of the sizes `size`"));
    };
    let known = found.values.iter().filter(|value| !value.is_nan()).count() as u64;
    if known < found.values.len() as u64 {
        return Err(source.truncated(Place::Whole, "sizes at points", found.values.len() as u64, known));
    }
    mesh_sizes::field(source, mesh, &found.values)
}

/// Reads the mesh.
pub fn parse<'a>(source: Source<'a>, options: &ReadOptions) -> Result<FileMesh<'a>, InputError> {
    let options = &ReadOptions { dimension: None, ..options.clone() };
    if is_binary(source) {
        return binary::parse(source, options);
    }
    parse_text(source, options, None)
}

/// Reads the mesh of a text, and the data of its nodes if they are requested.
fn parse_text<'a>(
    source: Source<'a>,
    options: &ReadOptions,
    mut data: Option<&mut Vec<NodeData>>,
) -> Result<FileMesh<'a>, InputError> {
    let mut lines = Lines::new(source.data);
    let mut version = None;
    let mut nodes: Option<(FileMesh<'a>, Tags)> = None;
    while let Some(line) = lines.next_data() {
        let keyword = line.keyword();
        match (keyword.as_str(), version, &mut nodes) {
            ("$meshformat", None, _) => version = Some(format(source, &mut lines)?),
            ("$nodes", Some(version), None) => {
                nodes = Some(read_nodes(source, options, &mut lines, version)?);
            }
            ("$elements", Some(version), Some((mesh, tags))) => {
                let section = Section { source, lines: &mut lines, what: "elements" };
                read_elements(section, version, mesh, tags)?;
            }
            ("$nodedata", Some(_), Some((_, tags))) if data.is_some() => {
                let found = data::read(source, &mut lines, tags)?;
                if let (Some(all), Some(found)) = (data.as_mut(), found) {
                    all.push(found);
                }
            }
            (_, None, _) => return Err(source.bad_line(&line, "$MeshFormat")),
            ("$nodes" | "$elements" | "$meshformat", ..) => {
                return Err(source.bad_line(&line, "one section $Nodes before the $Elements"));
            }
            (other, ..) if other.starts_with('$') => {
                let close = other.replacen('$', "$end", 1);
                if !lines.any(|line| line.keyword() == close) {
                    return Err(source.truncated(line.place(), "lines closing a section", 1, 0));
                }
            }
            _ => return Err(source.bad_line(&line, "a section such as $Nodes")),
        }
    }
    let missing = || source.truncated(Place::Line(lines.number()), "section $Nodes", 1, 0);
    nodes.map(|(mesh, _)| mesh).ok_or_else(missing)
}

/// Whether the format line, which is the second, has the number 1.
fn is_binary(source: Source<'_>) -> bool {
    let mut lines = Lines::new(source.data);
    let first = lines.next_data().is_some_and(|line| line.keyword() == "$meshformat");
    first && lines.next_data().is_some_and(|line| line.words().nth(1) == Some(b"1"))
}

fn format<'a>(source: Source<'a>, lines: &mut Lines<'a>) -> Result<Version, InputError> {
    let mut section = Section { source, lines, what: "format lines" };
    let line = section.line(1, 0)?;
    let words: Vec<&[u8]> = line.words().take(3).collect();
    let version = match words[..] {
        [b"4.1", b"0", _] => Version::FourOne,
        [version, b"0", _] if version == b"2" || version.starts_with(b"2.") => Version::Two,
        [version, ..] if integer(version).is_some() || version.contains(&b'.') => {
            let what = format!(".msh version {}", crate::read::text::excerpt(version));
            return Err(source.unsupported(line.place(), what, ADVICE));
        }
        _ => return Err(source.bad_line(&line, "`version 0 size`, such as `2.2 0 8`")),
    };
    section.end("$endmeshformat", 1, 1)?;
    Ok(version)
}

fn read_nodes<'a>(
    source: Source<'a>,
    options: &ReadOptions,
    lines: &mut Lines<'a>,
    version: Version,
) -> Result<(FileMesh<'a>, Tags), InputError> {
    let bytes = lines.rest().len();
    let mut section = Section { source, lines, what: "nodes" };
    let header = section.line(1, 0)?;
    let mut words = header.words();
    let first = source.count(&header, words.next(), "the number of nodes or blocks")?;
    let announced = match version {
        Version::Two => first,
        Version::FourOne => source.count(&header, words.next(), "the number of nodes")?,
    };
    let mut points = Collector::new(source, options, (header.place(), 3), (announced, bytes, 8))?;
    let mut tags = Vec::new();
    match version {
        Version::Two => {
            for found in 0..announced {
                let line = section.line(announced, found)?;
                let mut words = line.words();
                tags.push(tag(source, &line, words.next())?);
                points.push_words(&line, &mut words)?;
            }
        }
        Version::FourOne => {
            for _ in 0..first {
                let head = section.line(announced, points.met)?;
                let in_block =
                    source.count(&head, head.words().nth(3), "the number of nodes of the block")?;
                for found in 0..in_block {
                    let line = section.line(in_block, found)?;
                    tags.push(tag(source, &line, line.words().next())?);
                }
                for found in 0..in_block {
                    let line = section.line(in_block, found)?;
                    points.push_words(&line, &mut line.words())?;
                }
            }
        }
    }
    if points.met > announced {
        return Err(source.surplus(header.place(), "nodes", announced));
    }
    section.end("$endnodes", announced, points.met)?;
    let tags = Tags::new(&tags);
    if tags.doubled() {
        return Err(source.bad_line(&header, "nodes with distinct tags (a tag below occurs twice)"));
    }
    let base = u64::try_from(tags.first).unwrap_or(0);
    Ok((FileMesh::new(source, points, base), tags))
}

fn read_elements(
    mut section: Section<'_, '_>,
    version: Version,
    mesh: &mut FileMesh<'_>,
    tags: &Tags,
) -> Result<(), InputError> {
    let source = section.source;
    let header = section.line(1, 0)?;
    let mut words = header.words();
    let first = source.count(&header, words.next(), "the number of elements or blocks")?;
    if version == Version::Two {
        for found in 0..first {
            let line = section.line(first, found)?;
            let mut words = line.words().skip(1);
            let element = tag(source, &line, words.next())?;
            let skipped = source.count(&line, words.next(), "the number of tags")?;
            let skipped = usize::try_from(skipped).unwrap_or(usize::MAX);
            push(source, mesh, tags, element, &line, &mut words.skip(skipped))?;
        }
        return section.end("$endelements", first, first);
    }
    let announced = source.count(&header, words.next(), "the number of elements")?;
    let mut found = 0;
    for _ in 0..first {
        let head = section.line(announced, found)?;
        let element = tag(source, &head, head.words().nth(2))?;
        let in_block = source.count(&head, head.words().nth(3), "the number of elements of the block")?;
        for i in 0..in_block {
            let line = section.line(in_block, i)?;
            push(source, mesh, tags, element, &line, &mut line.words().skip(1))?;
        }
        found += in_block;
    }
    if found > announced {
        return Err(source.surplus(header.place(), "elements", announced));
    }
    section.end("$endelements", announced, found)
}

fn push(
    source: Source<'_>,
    mesh: &mut FileMesh<'_>,
    tags: &Tags,
    element: i64,
    line: &Line<'_>,
    words: &mut dyn Iterator<Item = &[u8]>,
) -> Result<(), InputError> {
    let kind = kind(element);
    if kind == CellKind::Other && mesh.other.is_none() {
        mesh.other = Some((line.place(), format!("a cell of Gmsh type {element}")));
    }
    let width = if kind == CellKind::Triangle { 3 } else { 4 };
    let Some(list) = mesh.list(kind) else {
        return Ok(());
    };
    for _ in 0..width {
        let node = index(source, line, words.next(), width)?;
        match tags.index(node) {
            Some(index) => list.flat.push(index),
            None => return Err(list.out_of_range(line.place(), i128::from(node))),
        }
    }
    if words.next().is_some() {
        return Err(source.bad_line(line, format!("{width} point ids at the end of the line, no more")));
    }
    Ok(())
}
