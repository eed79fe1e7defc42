//! `--raw`: coordinates in binary without a header.

use super::*;

/// The coordinates in a `.npy` file of doubles.
fn coordinates(array: &[u8]) -> Vec<f64> {
    let start = 10 + usize::from(u16::from_le_bytes([array[8], array[9]]));
    array[start..].as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect()
}

/// Writes `p.npy`, `p.raw` (f64), `p.be` (f64be), `p.raw.gz`, parts of it, and the single-precision files `s.npy` and `s.raw`.
fn files(place: &Place, sample: &str, dimension: usize) {
    place.good(&format!("generate {sample} -d {dimension} -q -o p.npy"));
    let numbers = coordinates(&fs::read(place.path("p.npy")).unwrap());
    let bytes = |write: fn(f64) -> [u8; 8]| numbers.iter().flat_map(|x| write(*x)).collect::<Vec<u8>>();
    let raw = bytes(f64::to_le_bytes);
    place.file("p.raw", &raw).file("p.be", bytes(f64::to_be_bytes));
    let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    gz.write_all(&raw).unwrap();
    place.file("p.raw.gz", gz.finish().unwrap());
    let row = 8 * dimension;
    let rows = raw.len() / row;
    for (part, ends) in [0, 1, 1, rows / 3, rows].map(|at| at.min(rows)).windows(2).enumerate() {
        place.file(&format!("part-{part}.bin"), &raw[ends[0] * row..ends[1] * row]);
    }
    let single: Vec<u8> = numbers.iter().flat_map(|x| (*x as f32).to_le_bytes()).collect();
    let head = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({rows}, {dimension}), }}\n");
    let length = (head.len() as u16).to_le_bytes();
    place.file("s.npy", [b"\x93NUMPY\x01\x00".as_slice(), &length, head.as_bytes(), &single].concat());
    place.file("s.raw", single);
}

const OUTPUTS: [&str; 2] = ["npy", "vtu"];

/// The outputs of a line.
fn outputs(place: &Place, line: &str) -> [Vec<u8>; 2] {
    place.good(&format!("{line} -q -o m.npy -o m.vtu"));
    OUTPUTS.map(|kind| fs::read(place.path(&format!("m.{kind}"))).unwrap())
}

#[test]
fn raw_files_have_the_outputs_of_arrays() {
    for (sample, d) in
        [("uniform -n 500", 3), ("clusters -n 500", 2), ("grid -n 343", 3), ("uniform -n 0", 2)]
    {
        let place = Place::new();
        files(&place, sample, d);
        for (command, array, inputs) in [
            (
                "triangulate",
                "p.npy",
                &["p.raw --raw f64", "p.be --raw f64be", "p.raw.gz --raw f64", "part-*.bin --raw f64"][..],
            ),
            ("triangulate", "s.npy", &["s.raw --raw f32"]),
            ("simulate", "p.npy", &["p.raw --raw f64"]),
        ] {
            let expected = outputs(&place, &format!("{command} {array}"));
            for input in inputs {
                assert!(
                    outputs(&place, &format!("{command} {input},{d}")) == expected,
                    "{command} {input},{d}"
                );
            }
            if command == "triangulate" && cfg!(unix) {
                for (input, processes) in inputs.iter().flat_map(|input| [1, 2, 5, 8].map(|n| (input, n))) {
                    let many = format!("--transport processes --processes {processes} --workers 8");
                    let found = outputs(&place, &format!("triangulate {input},{d} {many}"));
                    assert!(found == expected, "{input},{d} on {processes} processes");
                }
            }
        }
        if d == 3 {
            let flat = outputs(&place, "triangulate p.npy -d 2");
            assert!(outputs(&place, "triangulate p.raw --raw f64,3 -d 2") == flat);
        }
        let stream = fs::read(place.path("p.raw")).unwrap();
        let output = place.feed(&format!("triangulate - --raw f64,{d} -q -o -  --format npy"), &stream);
        assert!(output.stdout == outputs(&place, "triangulate p.npy")[0], "{}", stderr(&output));
    }
}

#[test]
fn errors_name_the_file_and_its_size() {
    let place = Place::new();
    place.file("cut.raw", [0; 100]).file("ok.raw", [0; 96]).file("nan.raw", f64::NAN.to_le_bytes().repeat(3));
    let words = ["cut.raw", "100 bytes", "24 bytes"];
    place.fails("triangulate cut.raw --raw f64,3", 3, &words);
    place.fails("simulate cut.raw --raw f64,3", 3, &words);
    place.fails("triangulate *.raw --raw f64,3", 3, &words);
    place.fails("triangulate nan.raw --raw f64,3", 3, &["nan.raw", "byte 0", "--skip-invalid"]);
    place.fails("triangulate ok.raw --raw f64,2 -d 3", 3, &["ok.raw", "-d"]);
    place.fails("triangulate ok.raw", 2, &["ok.raw", "--raw"]);
    let two = [0.0, 0.0, 0.0, f64::INFINITY, 1.0, f64::NAN].map(f64::to_le_bytes).concat();
    place.file("two.raw", two).fails("triangulate two.raw --raw f64,3", 3, &["byte 24", "point 1 ", "inf"]);
    for spec in ["f64", "f64,4", "i32,3", "64,3"] {
        place.fails(&format!("triangulate ok.raw --raw {spec}"), 2, &["--raw", "f64,3"]);
    }
    #[cfg(unix)]
    for line in ["cut.raw --raw f64,3", "*.raw --raw f64,3"] {
        place.fails(&format!("triangulate {line} --transport processes --workers 3"), 3, &words);
    }
}

/// The suggested command verifies the cells.
#[test]
fn cells_of_a_raw_file_are_verified() {
    let place = Place::new();
    files(&place, "uniform -n 100", 3);
    let talk = stderr(&place.good("triangulate p.raw --raw f64,3 -o cells.npy"));
    let line = talk.lines().find_map(|line| line.split("independently: septet ").nth(1)).unwrap();
    assert_eq!(line, "verify p.raw cells.npy --raw f64,3");
    place.good(line);
}
