//! `.pvtu` outputs and the folders of their pieces.

use super::*;

/// The files of the output `m.pvtu`.
fn pieces(place: &Place) -> Vec<(String, Vec<u8>)> {
    let folder = place.path("m.pieces");
    let mut found: Vec<(String, Vec<u8>)> = fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap())
        .map(|e| (e.file_name().into_string().unwrap(), fs::read(e.path()).unwrap()))
        .collect();
    found.push(("m.pvtu".to_owned(), fs::read(place.path("m.pvtu")).unwrap()));
    found.sort();
    found
}

#[test]
fn the_folder_of_pieces_is_replaced_whole() {
    let place = Place::new();
    let output = place.good("triangulate sample:clusters:900 --workers 5 -o m.pvtu");
    let talk = stderr(&output);
    assert!(talk.contains("m.pvtu (") && talk.contains("m.pieces") && talk.contains("ParaView"), "{talk}");
    let names: Vec<String> = pieces(&place).into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["0000.vtu", "0001.vtu", "0002.vtu", "0003.vtu", "0004.vtu", "m.pvtu"]);
    place.good("triangulate sample:clusters:900 --workers 2 -o m.pvtu -o m.vtu");
    let three = pieces(&place);
    assert_eq!(three.len(), 3);
    assert_eq!(place.names().into_iter().collect::<Vec<_>>(), ["m.pieces", "m.pvtu", "m.vtu"]);
    // Each piece is a file by itself.
    place.good("triangulate m.pieces/0000.vtu -o other.npy");
    for options in ["--threads 1", "--threads 2", "--transport sim --delivery-seed 3"] {
        place.good(&format!("triangulate sample:clusters:900 --workers 2 -o m.pvtu {options}"));
        assert!(pieces(&place) == three, "{options}");
    }
    place.good("simulate sample:clusters:900 --workers 2 -o m.pvtu --with-owner");
    assert_eq!(pieces(&place).len(), 3);
}

#[test]
fn pieces_have_columns_and_count_the_rows_of_the_input() {
    let place = Place::new();
    place.file("p.csv", "x,y,mass\n0,0,1\nnan,1,2\n1,0,3\n0,1,4\n1,1,5\n0.4,0.3,6\n");
    place.good("triangulate p.csv --skip-invalid --keep-columns --workers 1 -o m.pvtu");
    let piece = &pieces(&place)[0].1;
    let head = String::from_utf8_lossy(piece);
    assert!(head.contains("NumberOfPoints=\"5\"") && head.contains("Name=\"mass\""), "{head}");
    let bytes = |values: &[u64]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let masses: Vec<u64> = [1.0f64, 3.0, 4.0, 5.0, 6.0].iter().map(|m| m.to_bits()).collect();
    for expected in [bytes(&[0, 2, 3, 4, 5]), bytes(&masses)] {
        assert!(piece.windows(expected.len()).any(|found| found == expected), "{expected:?}");
    }
}

#[test]
fn outputs_that_cannot_have_pieces_are_refused() {
    let place = Place::new();
    place.file("p.xyz", SQUARE);
    let cube = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/domains/good/cube.poly");
    let domain = format!("mesh {cube} -o m.pvtu");
    for (line, exit, words) in [
        (domain.as_str(), 2, &["m.pvtu", "worker of each point", "write .vtu"][..]),
        ("triangulate missing.xyz -o m.pvtu.gz", 2, &["m.pvtu.gz", "omit .gz"]),
        ("triangulate missing.xyz -o - --format pvtu", 2, &["several files"]),
        ("generate uniform -n 10 -o m.pvtu", 2, &["unknown output format", ".vtu"]),
        ("triangulate missing.xyz -o none/m.pvtu", 1, &["none"]),
        ("triangulate missing.xyz -o m.pvtu --json m.pieces", 2, &["same file"]),
        ("triangulate p.xyz --with-owner", 2, &["-o OUT.pvtu"]),
    ] {
        place.fails(line, exit, words);
    }
    fs::create_dir(place.path("m.pieces")).unwrap();
    place.fails("triangulate missing.xyz -o m.pvtu -o m.pieces/0000.vtu", 2, &["same file"]);
    place.file("m.pieces/0000.vtu", "").file("m.pieces/notes.txt", "mine");
    place.fails("triangulate p.xyz -o m.pvtu", 1, &["m.pieces", "notes.txt", "help:"]);
    assert_eq!(fs::read(place.path("m.pieces/notes.txt")).unwrap(), b"mine");
    fs::remove_dir_all(place.path("m.pieces")).unwrap();
    place.file("m.pieces", "mine");
    place.fails("triangulate p.xyz -o m.pvtu", 1, &["m.pieces", "not a folder"]);
    fs::remove_file(place.path("m.pieces")).unwrap();
    place.good("triangulate p.xyz --workers 2 -o m.pvtu");
    place.fails("triangulate m.pieces/0000.vtu -o m.pvtu", 2, &["overwrite the input", "m.pieces"]);
    place.fails("triangulate m.pvtu -o a.vtu", 3, &["m.pvtu", "lists its pieces"]);
    place.good("verify p.xyz m.pvtu");
}

/// A disk that is full, imitated by the largest size of a file.
#[cfg(unix)]
#[test]
fn a_piece_that_cannot_be_written_leaves_the_former_output() {
    let place = Place::new();
    let program = env!("CARGO_BIN_EXE_septet");
    let limited = |is_new: bool| {
        let script = format!(
            "trap '' XFSZ; ulimit -f 16; exec {program} triangulate sample:uniform:2000 --workers 3 -o m.pvtu"
        );
        let output = Command::new("sh").current_dir(place.0.path()).args(["-c", &script]).output().unwrap();
        assert_eq!(code(&output), 1, "{}", stderr(&output));
        assert!(stderr(&output).contains("m.pieces/000"), "{}", stderr(&output));
        assert_eq!(place.names().is_empty(), is_new, "{:?}", place.names());
    };
    limited(true);
    place.good("triangulate sample:uniform:60 --workers 2 -o m.pvtu");
    let before = pieces(&place);
    limited(false);
    assert!(pieces(&place) == before);
    assert_eq!(place.names().into_iter().collect::<Vec<_>>(), ["m.pieces", "m.pvtu"]);
}
