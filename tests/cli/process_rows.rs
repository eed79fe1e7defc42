//! `--transport processes`: the rows and the messages of the processes.
#![cfg(unix)]

use super::processes::{outputs, same_run};
use super::*;

/// The processes draw their own rows of most kinds. Process 0 draws the others.
#[test]
fn samples_of_all_kinds_have_the_bytes_of_one_process() {
    let place = Place::new();
    for sample in [
        "poisson:500",
        "ball:400,d=2",
        "sphere:300",
        "grid:600,d=2",
        "fcc:500",
        "jittered:400,d=2,seed=7",
        "slab:500,seed=3",
        "line:200",
        "moment-curve:40",
        "shells:96,d=2",
        "well-spaced:300,d=2",
        "uniform:3",
        "uniform:0,d=2",
    ] {
        same_run(&place, &format!("triangulate sample:{sample}"), 8);
    }
    let talk = stderr(&place.good("triangulate sample:grid:30 --transport processes --processes 2"));
    assert_eq!(talk.matches("27 points instead of 30").count(), 1, "{talk}");
}

/// Messages that are cut into small parts arrive as whole messages.
#[test]
fn parts_do_not_change_the_bytes() {
    let place = Place::new();
    place.good("generate uniform -n 3000 -q -o u.npy");
    let of = |options: &str| {
        let line = "triangulate u.npy -q --workers 8 --transport processes -o m.npy -o m.vtu -o m.pvtu";
        place.good(&format!("{line} {options}"));
        outputs(&place, "m")
    };
    let expected = of("--processes 8");
    for processes in [5, 8] {
        for part in ["4096", "100", "1G"] {
            let found = of(&format!("--processes {processes} --part-bytes {part}"));
            assert!(found == expected, "{processes} processes, parts of {part} bytes");
        }
    }
    place.good("simulate u.npy -q --workers 8 -o s.npy -o s.vtu -o s.pvtu --view 0 --json one.json");
    let line = "simulate u.npy -q --workers 8 --transport processes --view 0 -o s.npy -o s.vtu -o s.pvtu --json several.json";
    let simulated = outputs(&place, "s");
    place.good(&format!("{line} --processes 5 --part-bytes 100"));
    assert!(outputs(&place, "s") == simulated, "simulate in parts");
    assert_eq!(place.json("several.json")["traffic"], place.json("one.json")["traffic"]);
    for part in ["0", "31", "1.5G", "many"] {
        let line = format!("triangulate u.npy --transport processes --part-bytes {part}");
        place.fails(&line, 2, &["--part-bytes"]);
    }
}

/// Adds a number to every integer in some bytes.
fn add(bytes: &mut [u8], n: u64) {
    for word in bytes.as_chunks_mut::<8>().0 {
        *word = (u64::from_le_bytes(*word) + n).to_le_bytes();
    }
}

/// The bytes of an output if the rows are numbered from `first_row`. In `.vtu` files, the row numbers are the first array.
fn numbered_from(label: &str, mut bytes: Vec<u8>, first_row: u64) -> Vec<u8> {
    if label == "npy" {
        let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        add(&mut bytes[start..], first_row);
    } else if label.contains("vtu") && label != "pvtu" {
        let mark = b"<AppendedData encoding=\"raw\">\n   _";
        let start = bytes.windows(mark.len()).position(|part| part == mark).unwrap() + mark.len();
        let head = String::from_utf8(bytes[..start].to_vec()).unwrap();
        assert!(head.split("<DataArray ").nth(1).unwrap().contains("GlobalPointIds"), "{head}");
        let length = u64::from_le_bytes(bytes[start..start + 8].try_into().unwrap()) as usize;
        add(&mut bytes[start + 8..][..length], first_row);
    }
    bytes
}

/// Rows above 2^32 change the numbers in outputs, and nothing else.
#[test]
fn rows_are_numbered_from_any_number() {
    let place = Place::new();
    place.good("generate grid -n 512 -q -o grid.npy");
    place.good("generate uniform -n 400 -d 2 -q -o uniform.npy");
    let rows = |n: usize, row: &dyn Fn(usize) -> String| (0..n).map(row).collect::<String>();
    place.file("repeated.xyz", rows(300, &|i| format!("{} {} {}\n", i * 37 % 61, i * 23 % 59, i * 11 % 3)));
    place.file("flat.csv", rows(50, &|i| format!("{},{},0\n", i % 7, i / 7)));
    place.file("line.xyz", rows(20, &|i| format!("{i} {i} {i}\n")));
    place.file("seven.xyz", rows(7, &|i| format!("{} {} {}\n", i % 2, i / 2, i * i)));
    for input in ["grid.npy", "uniform.npy", "repeated.xyz", "flat.csv", "line.xyz", "seven.xyz"] {
        place.good(&format!("triangulate {input} -q --workers 8 -o one.npy -o one.vtu -o one.pvtu"));
        let alone = outputs(&place, "one");
        for (processes, first_row) in [1, 2, 5, 8].into_iter().flat_map(|n| [(n, 1 << 33), (n, 1 << 62)]) {
            place.good(&format!(
                "triangulate {input} -q --workers 8 -o m.npy -o m.vtu -o m.pvtu --transport processes \
                 --processes {processes} --first-row {first_row}"
            ));
            let found = outputs(&place, "m");
            assert_eq!(found.len(), alone.len(), "{input}, {processes} processes");
            for ((label, found), (expected_label, expected)) in found.into_iter().zip(&alone) {
                assert_eq!(label, *expected_label);
                let expected = numbered_from(&label, expected.clone(), first_row);
                assert!(found == expected, "{input}, {processes} processes from {first_row}: {label}");
            }
        }
    }
    place.file("spread.xyz", "0 0 0\n1 0 0\n1e-300 0 1\n1e300 1 1\n2 2 2\n");
    for from in ["", "--first-row 8589934592"] {
        let line = format!("triangulate spread.xyz --transport processes --processes 2 {from}");
        place.fails(&line, 3, &["point 2 needs", "point 3 the"]);
    }
    let line = "triangulate grid.npy --transport processes --first-row 9223372036854775808";
    place.fails(line, 2, &["--first-row"]);
}
