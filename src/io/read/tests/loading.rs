//! Files, streams, gzip, formats by name and content, progress, speed.

use std::fmt::Write as _;
use std::io::{self, Read, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use flate2::Compression;
use flate2::write::GzEncoder;

use super::*;
use crate::format::Format;
use crate::read::{read, read_cells, read_cells_from, read_from};

fn gz(data: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(data).expect("memory");
    encoder.finish().expect("memory")
}

fn stream(data: &[u8], name: &str, options: &ReadOptions) -> Result<PointFile, InputError> {
    read_from(data, Path::new(name), None, options, &mut |_, _| ())
}

#[test]
fn gzip_by_name_and_by_content() {
    let text = b"1 2 3\n4 5 6\n";
    let mut two = gz(&text[..6]);
    two.extend(gz(&text[6..]));
    for name in ["a.xyz.gz", "A.XYZ.GZ", "a.xyz", "-"] {
        assert_eq!(stream(&two, name, &PLAIN).map(|f| f.points.len()).ok(), Some(2), "{name}");
    }
    for cut in 2..two.len() {
        let error = stream(&two[..cut], "a.xyz.gz", &PLAIN);
        assert!(
            matches!(error, Err(InputError::Gzip { .. })) || cut == gz(&text[..6]).len(),
            "{cut}: {error:?}"
        );
    }
    for short in [b"".as_slice(), b"\x1f", text] {
        assert!(matches!(stream(short, "a.xyz.gz", &PLAIN), Err(InputError::Gzip { .. })));
    }
}

#[test]
fn standard_input_is_recognised_by_content() {
    let files: [(Vec<u8>, usize); 11] = [
        (b"1 2\n3 4\n".to_vec(), 2),
        (npy_f8(), 4),
        (ply_binary(true), 4),
        (stl_binary(b"solid"), 4),
        (STL_ASCII.into(), 4),
        (b"OFF\n1 0 0\n0 0 0\n".to_vec(), 1),
        (b"CNOFF 1 0 0\n0 0 0\n".to_vec(), 1),
        (MSH2.into(), 4),
        (MEDIT.into(), 4),
        (vtu_raw(true), 4),
        (Vec::new(), 0),
    ];
    for (data, count) in files {
        assert_eq!(stream(&data, "-", &PLAIN).map(|f| f.points.len()).ok(), Some(count));
        assert_eq!(stream(&gz(&data), "-", &PLAIN).map(|f| f.points.len()).ok(), Some(count));
    }
    let node = ReadOptions { format: Some(Format::Node), ..PLAIN };
    assert_eq!(stream(b"1 2\n1 5 6\n", "-", &node).map(|f| f.first_id).ok(), Some(1));
    let error = stream(b"1 2\n1\n", "-", &PLAIN).expect_err("mixed");
    assert!(error.to_string().starts_with("standard input, line 2"), "{error}");
}

#[test]
fn names_of_formats() {
    assert_eq!("XYZ".parse(), Ok(Format::Xyz));
    assert_eq!("mesh".parse(), Ok(Format::Medit));
    assert!("dat".parse::<Format>().is_err());
    assert_eq!(Format::Xyz.name(), "xyz");
    assert_eq!(good("a.dat", "1 2 3\n").points.len(), 1);
    assert!(matches!(bad("a.dat", "words alone\n"), InputError::UnknownFormat { .. }));
    assert!(matches!(bad("a.foo", "1 2 3\n"), InputError::UnknownFormat { .. }));
    assert_eq!(good("a.dat", npy_f8()).points.len(), 4);
    assert_eq!(
        good_with("a.dat", "1 2 3\n", &ReadOptions { format: Some(Format::Xyz), ..PLAIN }).points.len(),
        1
    );
}

#[test]
fn files_on_disk() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.csv");
    std::fs::write(&path, "1,2,3\n").expect("written");
    assert_eq!(read(&path, &PLAIN, &mut |_, _| ()).map(|f| f.points.len()).ok(), Some(1));
    std::fs::write(folder.path().join("a.ele"), "1 3\n0 0 1 2\n").expect("written");
    let cells = read_cells(&folder.path().join("a.ele"), &CellOptions::default(), &mut |_, _| ());
    assert_eq!(cells.map(|c| c.cell_count()).ok(), Some(1));
    assert!(matches!(read(folder.path(), &PLAIN, &mut |_, _| ()), Err(InputError::Directory { .. })));
    let missing = read(&PathBuf::from("no/such.xyz"), &PLAIN, &mut |_, _| ()).expect_err("missing");
    assert!(matches!(missing, InputError::Missing { .. }));
    assert_eq!((missing.line(), missing.path()), (None, Path::new("no/such.xyz")));
}

/// Gives some bytes, then fails.
struct Breaking(usize);

impl Read for Breaking {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.0 == 0 {
            return Err(io::Error::other("the disk broke"));
        }
        let given = self.0.min(buffer.len());
        buffer[..given].fill(b'1');
        self.0 -= given;
        Ok(given)
    }
}

#[test]
fn failing_reads_are_reported() {
    for after in [0, 1, 5000] {
        let result = read_from(Breaking(after), Path::new("a.xyz"), None, &PLAIN, &mut |_, _| ());
        assert!(matches!(result, Err(InputError::Unreadable { .. })), "{result:?}");
    }
    let whole = gz(b"1 2 3\n");
    let broken = whole[..12].chain(Breaking(0));
    let result = read_from(broken, Path::new("a.xyz"), None, &PLAIN, &mut |_, _| ());
    assert!(matches!(result, Err(InputError::Unreadable { .. })), "{result:?}");
    let cells =
        read_cells_from(Breaking(9), Path::new("a.ele"), None, &CellOptions::default(), &mut |_, _| ());
    assert!(matches!(cells, Err(InputError::Unreadable { .. })));
}

#[test]
fn a_million_lines_are_read_fast_and_with_progress() {
    let mut text = String::new();
    for i in 0..1_000_000_u32 {
        let x = f64::from(i.wrapping_mul(2_654_435_761)) / 4_294_967_296.0;
        let _ = writeln!(text, "{x} {} {}", 1.0 - x, x * x);
    }
    let (mut calls, mut last) = (0, 0);
    let total = Some(text.len() as u64);
    let start = Instant::now();
    let file = read_from(text.as_bytes(), Path::new("a.xyz"), total, &PLAIN, &mut |read, of| {
        assert!(read > last && of == total);
        (calls, last) = (calls + 1, read);
    });
    let took = start.elapsed();
    println!("{} bytes in {took:?}", text.len());
    assert_eq!(file.map(|f| f.points.len()).ok(), Some(1_000_000));
    assert!(last == text.len() as u64 && calls >= text.len() >> 21, "{calls} calls up to {last}");
    assert!(took < Duration::from_secs(10), "{took:?}");
}
