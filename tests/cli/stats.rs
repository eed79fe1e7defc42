//! `--stats` and pictures: the same numbers and bytes on any machine.

use super::*;

/// The lines of the numbers in a summary: from the counts up to the files.
fn numbers(output: &Output) -> String {
    let talk = stderr(output);
    let lines = talk.lines().skip_while(|line| !line.starts_with("  contents"));
    let lines: Vec<&str> = lines.take_while(|line| !line.starts_with("  next")).collect();
    assert!(lines.len() > 5, "{talk}");
    lines.join("\n")
}

#[test]
fn numbers_do_not_depend_on_the_machine() {
    let place = Place::new();
    for sample in ["sample:uniform:3000", "sample:uniform:3000,d=2", "sample:sphere:500"] {
        let one = place.good(&format!("triangulate {sample} --workers 1 --stats --json one.json"));
        let expected = numbers(&one);
        let stats = place.json("one.json")["stats"].clone();
        let machines = [
            "--workers 3",
            "--workers 16",
            "--workers 4 --threads 1",
            "--workers 4 --transport processes --processes 2",
        ];
        for machine in machines {
            let other = place.good(&format!("triangulate {sample} {machine} --stats --json other.json"));
            assert_eq!(numbers(&other), expected, "{sample} {machine}");
            assert_eq!(place.json("other.json")["stats"], stats, "{sample} {machine}");
        }
    }
}

#[test]
fn the_report_has_the_numbers_if_they_are_asked_for() {
    let place = Place::new();
    place.file(
        "grid.csv",
        (0..49).map(|i| format!("{},{}\n", i % 7, i / 7)).collect::<Vec<_>>().concat() + "3,3\n",
    );
    let output = place.good("triangulate grid.csv --stats --json grid.json");
    let stats = &place.json("grid.json")["stats"];
    for (field, value) in [("points", 49), ("duplicates", 1), ("edges", 120), ("facets", 120), ("cells", 72)]
    {
        assert_eq!(stats[field], value, "{field}");
    }
    assert_eq!(
        stats["hull"],
        serde_json::json!({
            "facets": 24, "edges": 24, "vertices": 24, "volume": 36.0, "surface": 24.0
        })
    );
    assert_eq!(stats["extent"], serde_json::json!([[0.0, 6.0], [0.0, 6.0]]));
    let quality = &stats["quality"];
    assert_eq!(quality["least_angles"]["percentiles"]["p50"], 45.0);
    assert_eq!(quality["largest_angles"]["most"], 90.0);
    assert_eq!(quality["least_volume"], 0.5);
    assert!((stats["degrees"]["mean"].as_f64().unwrap() - 240.0 / 49.0).abs() < 1e-12);
    let talk = numbers(&output);
    for words in [
        "49 vertices, 120 edges, 72 triangles, 1 component, 1 duplicate",
        "area 36, perimeter 24",
        "x 0.0 to 6.0",
    ] {
        assert!(talk.contains(words), "no `{words}` in {talk}");
    }
    place.good("triangulate grid.csv --json none.json");
    assert!(place.json("none.json").get("stats").is_none());
    place.file("line.csv", "0,0\n1,1\n2,2\n");
    let flat = place.good("triangulate line.csv --stats");
    assert!(stderr(&flat).contains("3 vertices, 0 edges, 0 triangles"), "{}", stderr(&flat));
    place.fails("simulate grid.csv --stats", 2, &["--stats"]);
}

#[test]
fn pictures_are_of_the_plane_and_have_the_same_bytes() {
    let place = Place::new();
    let sample = "sample:uniform:400,d=2";
    place.good(&format!("triangulate {sample} --workers 1 -o a.svg -o a.svg.gz"));
    place.good(&format!("triangulate {sample} --workers 4 --transport processes --processes 2 -o b.svg"));
    place.good(&format!("triangulate {sample} --workers 9 --threads 1 -o c.svg"));
    let picture = fs::read(place.path("a.svg")).unwrap();
    assert!(
        picture == fs::read(place.path("b.svg")).unwrap()
            && picture == fs::read(place.path("c.svg")).unwrap()
    );
    let text = String::from_utf8(picture).unwrap();
    assert!(text.starts_with("<svg xmlns=") && text.ends_with("</svg>\n") && !text.contains("var("));
    assert_eq!(&fs::read(place.path("a.svg.gz")).unwrap()[..2], [0x1f, 0x8b]);
    let to_stream = place.good(&format!("triangulate {sample} --format svg -o -"));
    assert_eq!(String::from_utf8(to_stream.stdout).unwrap(), text);
    place.fails(
        "triangulate sample:uniform:50 -o s.svg",
        2,
        &["s.svg", "three coordinates", ".vtu", "--dimension 2"],
    );
    place.fails(
        "triangulate sample:uniform:50 --transport processes --processes 2 --workers 2 -o s.svg",
        2,
        &["s.svg", "three coordinates"],
    );
    let domains = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/domains/good");
    let map = domains.join("map.poly");
    place.good(&format!("mesh {} --size 0.3 -o map.svg", map.display()));
    assert!(fs::read_to_string(place.path("map.svg")).unwrap().contains("fill=\"#cfe3f6\""));
    place.fails(
        &format!("mesh {} -o cube.svg", domains.join("cube.poly").display()),
        2,
        &["cube.svg", "plane"],
    );
}
