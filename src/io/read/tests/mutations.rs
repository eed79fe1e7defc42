//! Mutated files of programs, which are read or refused, and never cause a panic or take long.
//!
//! `SEPTET_MUTATIONS=1000000 cargo test --release -p septet-io --features las --lib mutations` reads that many files. With
//! `prlimit --as=...` in front, an allocation far above the size of a file ends the test.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use super::*;

/// The number of mutated files that are read by default.
const FILES: u64 = 20_000;

/// The longest time to read a file, of which the largest has 8 kB.
const LONGEST: Duration = Duration::from_secs(2);

/// Numbers and words that a file replaces by others.
const WORDS: [&[u8]; 14] = [
    b"-1",
    b"0",
    b"4294967295",
    b"18446744073709551615",
    b"1e308",
    b"nan",
    b"1d5",
    b",",
    b";",
    b"\r",
    b"\xff\xfe",
    b"\x00",
    b"\xff\xff\xff\xff\xff\xff\xff\x7f",
    b"#",
];

/// A generator of pseudo-random numbers (`SplitMix64`).
struct Draws(u64);

impl Draws {
    /// Returns a number below `n`, or 0.
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut x = self.0;
        x = (x ^ x >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        x = (x ^ x >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        (x ^ x >> 31) as usize % n.max(1)
    }

    /// Changes a file in one place.
    fn mutate(&mut self, data: &mut Vec<u8>) {
        let at = self.below(data.len());
        let end = (at + 1 + self.below(24)).min(data.len());
        match self.below(7) {
            0 if !data.is_empty() => data[at] ^= 1 << self.below(8),
            1 => data.truncate(at),
            2 => drop(data.drain(at..end)),
            3 => data.splice(at..at, data[at..end].to_vec()).for_each(drop),
            4 => data.splice(at..end, WORDS[self.below(WORDS.len())].iter().copied()).for_each(drop),
            5 => data.splice(at..at, WORDS[self.below(WORDS.len())].iter().copied()).for_each(drop),
            _ => {
                let from = self.below(data.len());
                let piece = data[from..(from + end - at).min(data.len())].to_vec();
                data.splice(at..at, piece).for_each(drop);
            }
        }
    }
}

/// Returns the files of the reports and of programs, in the order of their paths.
fn files() -> Vec<(PathBuf, Vec<u8>)> {
    let root = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/reports"));
    let mut all = Vec::new();
    for folder in ["points", "made"] {
        for entry in std::fs::read_dir(root.join(folder)).unwrap() {
            let path = entry.unwrap().path();
            let data = std::fs::read(&path).unwrap();
            if !path.ends_with("cases.json") && data.len() <= 8192 {
                all.push((PathBuf::from(path.file_name().unwrap()), data));
            }
        }
    }
    all.sort();
    all
}

#[test]
fn mutated_files_are_survived() {
    let files = files();
    assert!(files.len() > 120, "{} files", files.len());
    let count = std::env::var("SEPTET_MUTATIONS").map_or(FILES, |text| text.parse().unwrap());
    let mut read = 0;
    for draw in 0..count {
        let mut draws = Draws(draw);
        let (path, data) = &files[draws.below(files.len())];
        let mut data = data.clone();
        for _ in 0..=draws.below(3) {
            draws.mutate(&mut data);
        }
        let options = [PLAIN, SKIP, TWO, THREE][draws.below(4)].clone();
        let column = [None, None, None, None, Some("1"), Some("4")][draws.below(6)];
        let options =
            ReadOptions { weights: column.and_then(|name| weights::weights(name).weights), ..options };
        let start = Instant::now();
        let found = std::panic::catch_unwind(|| {
            let found = points(path, &data, &options);
            let _ = cell_list(path, &data, &CellOptions::default());
            found
        });
        let Ok(found) = found else { panic!("draw {draw} of {} panics", path.display()) };
        assert!(start.elapsed() < LONGEST, "draw {draw} of {} takes {:?}", path.display(), start.elapsed());
        if let Ok(file) = found {
            assert!(
                file.points.coordinates().iter().all(|c| c.is_finite()),
                "draw {draw} of {}",
                path.display()
            );
            let weights = file.weights.unwrap_or_else(|| vec![0.0; file.points.len()]);
            assert!(weights.len() == file.points.len() && weights.iter().all(|weight| weight.is_finite()));
            read += 1;
        }
    }
    assert!(read > count / 10, "only {read} of {count} files still have points");
}
