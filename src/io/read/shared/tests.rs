//! Tests of reading by several processes. The result is compared with the one of a single process.

mod errors;
mod weights;
use std::fs;
use std::io::Write;
use std::ops::Range;
use std::path::PathBuf;
use std::thread;

use proptest::prelude::*;
use septet_core::Remedy;
use septet_core::model::Points;
use septet_protocol::wire::{Ended, Processes};

use crate::thread_wire;
use tempfile::TempDir;

use super::super::{Extent, FileList, ListedFile, PointFile, ReadOptions, read, read_list};
use super::{Call, LIMITS, Limits, SharedPoints};

/// Numbers of processes.
const MANY: [u32; 5] = [1, 2, 3, 5, 8];

/// Limits with steps of a few bytes and rows.
const SMALL: Limits = Limits { step: 7, round: 2, ..LIMITS };

/// A folder with files.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        Folder(tempfile::tempdir().unwrap())
    }

    fn of(files: &[(&str, &str)]) -> Self {
        let folder = Folder::new();
        for (name, text) in files {
            folder.write(name, text);
        }
        folder
    }

    fn write(&self, name: &str, data: impl AsRef<[u8]>) {
        fs::write(self.0.path().join(name), data).unwrap();
    }

    fn paths(&self, names: &[&str]) -> Vec<PathBuf> {
        names.iter().map(|name| self.0.path().join(name)).collect()
    }

    /// Compares the result of several numbers of processes with the one of a single process.
    fn check(&self, names: &[&str], options: &ReadOptions) {
        let files = self.paths(names);
        let alone = alone(&files, options);
        for processes in MANY {
            for limits in [LIMITS, SMALL] {
                compare(&files, options, &alone, processes, limits, even);
            }
            compare(&files, options, &alone, processes, SMALL, uneven);
        }
    }
}

/// The block of a process.
type Block = fn(u64, u32, u32) -> Range<u64>;

/// Blocks of equal size.
fn even(rows: u64, process: u32, processes: u32) -> Range<u64> {
    let cut = |process: u32| rows * u64::from(process) / u64::from(processes);
    cut(process)..cut(process + 1)
}

/// Blocks of which the last are the largest and the second is empty.
fn uneven(rows: u64, process: u32, processes: u32) -> Range<u64> {
    let cut = |process: u32| {
        let process = if process == 2 && processes > 2 { 1 } else { process };
        rows * u64::from(process * process) / u64::from(processes * processes)
    };
    cut(process)..cut(process + 1)
}

/// Reads files by a number of processes.
fn together(
    files: &[PathBuf],
    options: &ReadOptions,
    processes: u32,
    limits: Limits,
    block: Block,
) -> Vec<Result<SharedPoints, Ended>> {
    let read = |mut wire: thread_wire::Threads| {
        let mut all = Processes::over(&mut wire);
        let process = all.process();
        Call { files, options, limits, stop: &|| false }
            .read(&mut all, &|rows| block(rows, process, processes))
    };
    thread::scope(|scope| {
        let threads: Vec<_> =
            thread_wire::connect(processes).into_iter().map(|wire| scope.spawn(move || read(wire))).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    })
}

/// The message of an error and its remedy.
type Described = (String, String);

/// Reads files by one process without a wire.
fn alone(
    files: &[PathBuf],
    options: &ReadOptions,
) -> Result<(PointFile, Option<Vec<ListedFile>>), Described> {
    if let [file] = files {
        return match read(file, options, &mut |_, _| {}) {
            Ok(file) => Ok((file, None)),
            Err(error) => Err((error.to_string(), Remedy::sent(error.remedy()))),
        };
    }
    match read_list(&FileList::new(files.to_vec()), options, &mut |_, _| {}) {
        Ok(list) => Ok((list.content, Some(list.files))),
        Err(error) => Err((error.to_string(), Remedy::sent(error.remedy()))),
    }
}

fn bits(points: &Points) -> Vec<u64> {
    points.coordinates().iter().map(|number| number.to_bits()).collect()
}

fn compare(
    files: &[PathBuf],
    options: &ReadOptions,
    alone: &Result<(PointFile, Option<Vec<ListedFile>>), Described>,
    processes: u32,
    limits: Limits,
    block: Block,
) {
    let parts = together(files, options, processes, limits, block);
    let (file, listed) = match alone {
        Ok(alone) => alone,
        Err(message) => {
            for part in parts {
                let Err(Ended::Refused(refused)) = part else { panic!("{part:?} instead of {message:?}") };
                assert_eq!((refused.message, refused.remedy), *message, "{processes} processes");
            }
            return;
        }
    };
    let (mut coordinates, mut weights, mut index) = (Vec::new(), Vec::new(), Vec::new());
    for (process, part) in parts.into_iter().enumerate() {
        let part = part.unwrap_or_else(|error| panic!("{processes} processes: {error}"));
        let own = block(file.points.len() as u64, process as u32, processes);
        assert_eq!(part.points.dimension(), file.points.dimension());
        assert_eq!((part.first, part.points.len() as u64), (own.start, own.end - own.start));
        assert_eq!((part.rows, part.skipped), (file.points.len() as u64, file.skipped as u64));
        assert_eq!((&part.notes, part.first_id), (&file.notes, file.first_id), "{processes} processes");
        assert_eq!(part.coordinate_type, file.coordinate_type);
        assert_eq!(part.reading.as_ref(), Some(&file.reading), "{processes} processes, {limits:?}");
        assert_eq!(part.extent, Extent::of(&file.points));
        assert!(listed.as_ref().is_none_or(|listed| *listed == part.files), "{:?}", part.files);
        assert_eq!(part.source_index.is_some(), file.source_index.is_some());
        assert_eq!(part.weights.is_some(), file.weights.is_some());
        coordinates.extend(bits(&part.points));
        weights.extend(part.weights.into_iter().flatten());
        index.extend(part.source_index.into_iter().flatten());
    }
    assert!(coordinates == bits(&file.points), "{processes} processes, {limits:?}: other coordinates");
    assert_eq!(weights, file.weights.clone().unwrap_or_default(), "{processes} processes, {limits:?}");
    assert_eq!(index, file.source_index.clone().unwrap_or_default(), "{processes} processes, {limits:?}");
}

/// The bytes of an array of a `NumPy` type.
fn npy(kind: &str, rows: usize, columns: usize, fortran: bool, data: &[u8]) -> Vec<u8> {
    let order = if fortran { "True" } else { "False" };
    let mut header =
        format!("{{'descr': '<{kind}', 'fortran_order': {order}, 'shape': ({rows}, {columns}), }}");
    while !(header.len() + 11).is_multiple_of(64) {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

/// Numbers of a kind, of which some are -0.0 or too large for a double.
fn data(kind: &str, numbers: usize) -> Vec<u8> {
    let number = |i: usize| {
        let value = if i.is_multiple_of(5) { -0.0 } else { (i * 7919 % 1013) as f64 / 8.0 - 30.0 };
        match kind {
            "f4" => (value as f32).to_le_bytes().to_vec(),
            "f8" => value.to_le_bytes().to_vec(),
            "i2" => (i as i16 - 9).to_le_bytes().to_vec(),
            _ => (i as i64).wrapping_mul((1 << 53) + 1).to_le_bytes().to_vec(),
        }
    };
    (0..numbers).flat_map(number).collect()
}

/// The text of a table.
fn table(rows: usize, separator: &str, end: &str) -> String {
    let row = |i: usize| {
        let numbers: Vec<String> = (0..3).map(|j| format!("{}", (i * 3 + j) as f64 / 7.0 - 1.0)).collect();
        numbers.join(separator) + end
    };
    (0..rows).map(row).collect()
}

fn plain() -> ReadOptions {
    ReadOptions::default()
}

fn skipping() -> ReadOptions {
    ReadOptions { skip_invalid: true, ..plain() }
}

#[test]
fn arrays_are_read_in_blocks() {
    let folder = Folder::new();
    for kind in ["f4", "f8", "i8", "i2"] {
        for (rows, columns) in (0..10).flat_map(|rows| [(rows, 2), (rows, 3)]).chain([(1000, 3)]) {
            folder.write("a.npy", npy(kind, rows, columns, false, &data(kind, rows * columns)));
            let files = folder.paths(&["a.npy"]);
            let alone = alone(&files, &plain());
            for processes in MANY {
                compare(&files, &plain(), &alone, processes, if rows > 9 { LIMITS } else { SMALL }, even);
            }
        }
    }
    folder.check(&["a.npy"], &ReadOptions { dimension: Some(2), ..plain() });
    folder.write("long.npy", [npy("f8", 4, 3, false, &data("f8", 12)), vec![7; 5]].concat());
    folder.check(&["long.npy"], &plain());
    folder.write("fortran.npy", npy("f8", 7, 3, true, &data("f8", 21)));
    folder.check(&["fortran.npy"], &plain());
}

fn raw(text: &str) -> ReadOptions {
    ReadOptions { raw: Some(text.parse().unwrap()), ..plain() }
}

#[test]
fn raw_files_are_read_in_blocks() {
    let folder = Folder::new();
    for (text, kind) in
        [("f32,2", "f4"), ("f64,2", "f8"), ("f32,3", "f4"), ("f64,3", "f8"), ("f64be,3", "f8")]
    {
        let columns = if text.ends_with('2') { 2 } else { 3 };
        for rows in (0..10).chain([1000]) {
            folder.write("a.raw", data(kind, rows * columns));
            let files = folder.paths(&["a.raw"]);
            let alone = alone(&files, &raw(text));
            for processes in MANY {
                compare(&files, &raw(text), &alone, processes, if rows > 9 { LIMITS } else { SMALL }, even);
            }
        }
        folder.check(&["a.raw"], &ReadOptions { dimension: Some(2), ..raw(text) });
        folder.write("empty", []);
        folder.write("b.bin", data(kind, 7 * columns));
        folder.check(&["a.raw", "empty", "b.bin", "a.raw"], &raw(text));
        folder.check(&["empty", "empty"], &raw(text));
    }
    let mut numbers = data("f8", 300);
    for row in [0, 1, 50, 98, 99] {
        numbers[row * 24..row * 24 + 8].copy_from_slice(&f64::NAN.to_le_bytes());
    }
    // The first coordinate of `packed` looks like a header of gzip.
    let mut packed = data("f8", 60);
    packed[..2].copy_from_slice(&[0x1f, 0x8b]);
    let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    gz.write_all(&packed).unwrap();
    folder.write("numbers", numbers);
    folder.write("packed", packed);
    folder.write("a.raw.gz", gz.finish().unwrap());
    folder.write("short", vec![0; 25]);
    folder.write("c.npy", npy("f8", 2, 3, false, &data("f8", 6)));
    for names in [
        &["numbers"][..],
        &["packed"],
        &["a.raw.gz"],
        &["packed", "a.raw.gz", "numbers", "packed"],
        &["short"],
        &["packed", "short"],
        &["packed", "c.npy"],
        &["absent"],
    ] {
        folder.check(names, &raw("f64,3"));
        folder.check(names, &ReadOptions { skip_invalid: true, ..raw("f64,3") });
        folder.check(names, &ReadOptions { columns: Some(vec!["1".into(), "2".into()]), ..raw("f64,3") });
        folder.check(names, &ReadOptions { dimension: Some(3), ..raw("f64,2") });
    }
}

#[test]
fn a_process_reads_only_its_rows_of_an_array() {
    let folder = Folder::new();
    folder.write("a.npy", npy("f8", 1000, 3, false, &data("f8", 3000)));
    let files = folder.paths(&["a.npy"]);
    let mut wire = thread_wire::connect(1).remove(0);
    let mut processes = Processes::over(&mut wire);
    let read = super::read_shared(&mut processes, &files, &plain(), &|rows| 0..rows, &|| false).unwrap();
    assert_eq!((read.points.len(), processes.moved()), (1000, [0, 0]));
}

/// Returns 30 lines of text.
fn rows_of(row: impl Fn(u32) -> String) -> String {
    (0..30).map(row).collect::<Vec<String>>().join("\n") + "\n"
}

#[test]
fn tables_are_read_in_blocks() {
    for (name, text) in [
        ("a.xyz", table(40, " ", "\n")),
        ("a.xyz", table(40, "\t", "\r\n") + "1 2 3"),
        ("a.txt", table(40, " ", "\r") + "# end"),
        (
            "a.txt",
            format!("\u{feff}# head\n\n% other\n{}\n // c\n  \n1 2 3 # end", table(9, "  ", " \n\n# x\r\n")),
        ),
        ("a.csv", format!("y,name,x,z\n{}", table(20, ",", ",\n").replace(",\n", ",5\n"))),
        ("a.csv", format!("\"x [m]\";\"y [m]\"\r\n{}", table(20, ";", ";\"a;b\"\r\n"))),
        ("a.csv", "1,2,3\n4,5,6\n1,2,3,4\n7,8,9\n1,2,3,4\n1,2,3\n".repeat(3)),
        ("a.csv", "a,b\n1,2\n3,4\n".to_string()),
        ("a.csv", "lat;lon;h\n47,5;9,25;1\n".to_string() + &"47,5;9,5;2\n# c\n\n".repeat(20)),
        ("a.txt", "x y z\n".to_string() + &rows_of(|i| format!("{i} 0.5 1 2"))),
        ("a.txt", rows_of(|i| format!("{i} 0.5 1"))),
        ("a.txt", rows_of(|i| format!("{} 0.5 1", i % 29))),
        ("a.txt", format!("30 2\n{}", "0.5 1\n".repeat(30))),
        ("a.txt", format!("3\n30\n{}", "0.5 1 2\n".repeat(30))),
        ("a.txt", format!("29 2\n{}", "0.5 1\n".repeat(30))),
        ("a.txt", format!("// z y x\n30\n{}", "0.5 1 2\n#7 1 2\n".repeat(30))),
        ("a.txt", "id\tx\ty\n".to_string() + &"Tree 7\t1\t2\n".repeat(30)),
        ("a.txt", "name x y\n".to_string() + &"#7 1 2\n# 1 2\n".repeat(30)),
        ("a.txt", "OFF\n2 0 0\n0 0 0\n1 1 1\n".to_string()),
        ("a.txt", "3 2\n1 0.5 0\n2 1 0\n3 0 1\n".to_string()),
        ("a.txt", "ncols 2\nnrows 1\n1 2\n".to_string()),
        ("a.xyz", format!("41\n{}4 5 6\n", table(40, " ", "\n"))),
        ("a.xyz", "3\ncomment\n1 2 3\n4 5 6\n7 8 9\n".to_string()),
        ("a.xyz", "2\na comment\nH 1 2 3\nO 4 5 6\n".to_string()),
        ("a.txt", String::new()),
        ("a.txt", "# nothing\n\n".to_string()),
        ("a.txt", "1 2 3".to_string()),
    ] {
        let folder = Folder::of(&[(name, &text)]);
        folder.check(&[name], &plain());
        folder.check(&[name], &skipping());
        folder.check(&[name], &ReadOptions { dimension: Some(2), ..plain() });
    }
    let folder = Folder::of(&[("a.csv", "a,b,c,d,e\n1,2,3,4,5\n6,7,8,9,10\n11,12,13,14,15\n")]);
    let columns = Some(vec!["e".to_string(), "B".to_string()]);
    folder.check(&["a.csv"], &ReadOptions { columns, ..plain() });
}

#[test]
fn invalid_rows_are_dropped() {
    let mut numbers = data("f8", 300);
    for row in [0, 1, 2, 50, 51, 98, 99] {
        numbers[row * 24..row * 24 + 8].copy_from_slice(&f64::NAN.to_le_bytes());
    }
    let folder = Folder::of(&[
        ("a.xyz", "nan 1 2\n0 0 0\n# c\n1 x 2\n1 1 1\n2 2 2\n3 inf 3\n4 4 4\n5 5 5\n5 5 y\n"),
        ("none.xyz", "nan 1 2\nnan 1 2\n"),
        ("b.csv", "x,y,z\n1,2,\n1,2,3\n,,\n3,4,5\n"),
    ]);
    folder.write("a.npy", npy("f8", 100, 3, false, &numbers));
    for names in
        [&["a.xyz"][..], &["none.xyz"], &["b.csv"], &["a.npy"], &["none.xyz", "b.csv", "none.xyz", "a.xyz"]]
    {
        folder.check(names, &skipping());
        folder.check(names, &plain());
    }
    folder.check(&["a.npy", "a.xyz", "b.csv"], &skipping());
}

#[test]
fn lists_are_read_in_blocks() {
    let folder = Folder::of(&[
        ("a.xyz", &table(13, " ", "\n")),
        ("b.csv", &format!("x,y,z,more\n{}", table(5, ",", ",1\n"))),
        ("empty.txt", ""),
        ("header.csv", "x,y,z\n"),
        ("c.node", "4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n"),
        ("one.txt", "1 2 3"),
    ]);
    let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    gz.write_all(table(11, " ", "\n").as_bytes()).unwrap();
    folder.write("d.xyz.gz", gz.finish().unwrap());
    folder.write("e.npy", npy("f4", 6, 3, false, &data("f4", 18)));
    folder.write("empty.npy", npy("f8", 0, 3, false, &[]));
    folder.write("plane.npy", npy("f4", 6, 2, false, &data("f4", 12)));
    for names in [
        &["a.xyz", "empty.txt", "b.csv"][..],
        &["empty.txt", "empty.npy", "header.csv", "a.xyz"],
        &["empty.txt", "header.csv"],
        &["d.xyz.gz"],
        &["c.node"],
        &["c.node", "c.node"],
        &["d.xyz.gz", "a.xyz", "c.node", "one.txt", "e.npy", "b.csv", "empty.npy", "b.csv"],
        &["one.txt"; 9],
        &["a.xyz", "plane.npy"],
        &["header.csv"],
        &[],
    ] {
        folder.check(names, &plain());
        folder.check(names, &skipping());
    }
    folder.check(&["a.xyz", "plane.npy"], &ReadOptions { dimension: Some(2), ..plain() });
}

/// Lines of text tables, good and bad.
fn line() -> impl Strategy<Value = String> {
    prop_oneof![
        6 => (0..99_u8, 0..99_u8, 0..99_u8).prop_map(|(x, y, z)| format!("{x} {y} {z}")),
        1 => Just("# comment".to_string()),
        1 => Just(String::new()),
        1 => Just("1 2 3 4".to_string()),
        1 => Just("1 nan 3".to_string()),
        1 => Just(" 1e-300  -0.0\t7 // c".to_string()),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn any_cut_gives_the_same_rows(
        lines in proptest::collection::vec((line(), prop_oneof![Just("\n"), Just("\r\n"), Just("\r")]), 0..12),
        step in 1_usize..40,
        skip_invalid: bool,
        last: bool,
    ) {
        let mut text: String = lines.iter().flat_map(|(line, end)| [line, *end]).collect();
        if !last {
            text.push_str("5 6 7");
        }
        let folder = Folder::of(&[("a.xyz", &text), ("b.xyz", "1 2 3\r\n4 5 6")]);
        let options = ReadOptions { skip_invalid, ..plain() };
        for names in [&["a.xyz"][..], &["b.xyz", "a.xyz", "a.xyz"]] {
            let files = folder.paths(names);
            let alone = alone(&files, &options);
            for processes in 1..=12 {
                let block = if processes % 2 == 0 { even } else { uneven };
                compare(&files, &options, &alone, processes, Limits { step, ..SMALL }, block);
            }
        }
    }
}

#[test]
fn a_binary_surface_named_as_a_table_is_read_whole() {
    let mut file = "1 2 3\n".repeat(13).into_bytes();
    file.resize(80, b' ');
    file.extend(2_u32.to_le_bytes());
    for corner in 0..2 {
        file.extend([0; 12]);
        (0..9).for_each(|i| file.extend((corner as f32 + i as f32 * 0.5).to_le_bytes()));
        file.extend([0; 2]);
    }
    let folder = Folder::new();
    folder.write("a.xyz", &file);
    folder.check(&["a.xyz"], &plain());
    let (read, _) = alone(&folder.paths(&["a.xyz"]), &plain()).unwrap();
    assert!(read.notes.iter().any(|note| note.contains("merged")), "{:?}", read.notes);
}
