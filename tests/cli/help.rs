//! Help, manual, errors of the parser, and text on terminals.

use super::*;

const COMMANDS: [&str; 21] = [
    "triangulate",
    "simulate",
    "generate",
    "mesh",
    "verify",
    "locate",
    "interpolate",
    "voronoi",
    "alpha",
    "predict",
    "report",
    "scale",
    "fit",
    "fold",
    "rival direct",
    "rival incremental",
    "rival splay",
    "reproduce",
    "schema",
    "completions",
    "man",
];

/// The help of a command at a width of the terminal.
fn help(place: &Place, command: &str, option: &str, columns: u32) -> String {
    let mut run = place.command(&format!("{command} {option}"));
    let output = run.env("COLUMNS", columns.to_string()).output().unwrap();
    assert_eq!(code(&output), 0, "{command} {option}: {}", stderr(&output));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn help_fits_the_terminal_and_keeps_examples_whole() {
    let place = Place::new();
    for command in COMMANDS.into_iter().chain([""]) {
        let wide = help(&place, command, "--help", 100);
        for columns in [80, 100] {
            let text = help(&place, command, "--help", columns);
            let long = text.lines().find(|line| line.chars().count() > columns as usize);
            // The usage and lists of values are not wrapped.
            let long = long.filter(|line| !line.contains("Usage:") && !line.contains('|'));
            assert_eq!(long, None, "{command} at {columns}");
            let examples = |text: &str| {
                let examples = text.lines().map(str::to_owned);
                examples.filter(|l| l.starts_with("  septet ") || l.contains("| septet")).collect::<Vec<_>>()
            };
            assert_eq!(examples(&text), examples(&wide), "{command} at {columns}: broken examples");
        }
        assert!(wide.contains("Examples:"), "{command}: no examples");
    }
}

#[test]
fn the_short_help_lists_the_options_that_matter() {
    let place = Place::new();
    for command in ["triangulate", "simulate", "mesh"] {
        let options = |text: &str| text.lines().filter(|l| l.trim_start().starts_with('-')).count();
        let short = help(&place, command, "-h", 100);
        let long = help(&place, command, "--help", 100);
        assert!(options(&short) <= 18 && options(&short) < options(&long), "{command}: {short}");
        for heading in ["Output:", "Machine:", "Reports:", "Messages:"] {
            assert!(short.contains(heading) && long.contains(heading), "{command}: no {heading}");
        }
    }
    assert_ne!(help(&place, "", "-h", 100), help(&place, "", "--help", 100));
}

#[test]
fn the_nearest_command_is_named_first() {
    let place = Place::new();
    let talk = stderr(&place.run("triangluate a.xyz"));
    let first = talk.split('\'').nth(3);
    assert_eq!(first, Some("triangulate"), "{talk}");
    assert!(stderr(&place.run("")).starts_with("Try: septet triangulate"));
}

#[test]
fn a_manual_page_is_written_for_each_command() {
    let place = Place::new();
    place.good("man --dir pages");
    for page in ["septet.1", "septet-mesh.1", "septet-rival-incremental.1", "septet-schema.1"] {
        let text = fs::read_to_string(place.path("pages").join(page)).unwrap();
        assert!(text.contains(".TH septet"), "{page}");
    }
}

#[cfg(unix)]
#[test]
fn a_closed_pipe_is_silent() {
    let place = Place::new();
    for line in ["generate uniform -n 100000 -q", "reproduce --list", "man", "schema run", "--help"] {
        let mut command = place.command(line);
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!(code(&output), 0, "{line}: {}", stderr(&output));
        assert!(output.stderr.is_empty(), "{line}: {}", stderr(&output));
    }
}

#[test]
fn control_characters_in_names_do_not_reach_the_terminal() {
    let place = Place::new();
    for arguments in [
        ["triangulate", "a\x1b]0;title\x07.xyz"],
        ["\x1b[31mtriangulate", "a.xyz"],
        ["triangulate", "--\x1b[31mred"],
        ["report", "a\x1b[2Jb.json"],
        ["mesh", "a\x1b[2Jb.poly"],
    ] {
        let output = place.command("").args(arguments).output().unwrap();
        assert_ne!(code(&output), 0);
        assert!(!stderr(&output).contains('\x1b'), "{arguments:?}: {:?}", stderr(&output));
    }
}

#[test]
fn the_first_summary_is_short_and_readable() {
    let place = Place::new();
    let output = place.good("triangulate sample:well-spaced:2000 -o mesh.vtu");
    let talk = stderr(&output);
    assert!(output.stdout.is_empty() && talk.lines().count() <= 45, "{talk}");
    for words in
        ["points, ", "tetrahedra", "hull facets", "generate ", "total ", "wrote", "mesh.vtu (", "ParaView"]
    {
        assert!(talk.contains(words), "no `{words}`: {talk}");
    }
    assert!(!talk.contains('{') && !talk.contains("read "), "{talk}");
    place.file("four.xyz", "0 0 0\n1 0 0\n0 1 0\n0 0 1\n");
    let talk = stderr(&place.good("triangulate four.xyz --workers 1"));
    assert!(
        talk.contains("4 points, 6 edges, 4 facets, 1 tetrahedron, 4 hull facets")
            && talk.contains("1 worker,"),
        "{talk}"
    );
}

/// A file in the place of a command. Each advised command runs.
#[test]
fn a_file_in_the_place_of_a_command_gets_its_command() {
    let place = Place::new();
    let domains = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/domains/good"));
    for name in ["cube.poly", "cube.stl"] {
        fs::copy(domains.join(name), place.path(name)).unwrap();
    }
    place.file("points.csv", "x,y,z\n0,0,0\n1,0,0\n0,1,0\n0,0,1\n1,1,1\n").file("my points.xyz", SQUARE);
    place.file("words", SQUARE);
    place.good("triangulate points.csv -q -o m.vtu -o m.pvtu -o m.ele --json run.json");
    for (file, commands) in [
        ("points.csv", &["septet triangulate points.csv -o mesh.vtu"][..]),
        ("my points.xyz", &["septet triangulate 'my points.xyz' -o mesh.vtu"]),
        ("words", &["septet triangulate words -o mesh.vtu"]),
        ("sample:uniform:50", &["septet triangulate sample:uniform:50 -o mesh.vtu"]),
        ("cube.poly", &["septet mesh cube.poly -o mesh.vtu"]),
        ("cube.stl", &["septet mesh cube.stl -o mesh.vtu", "septet triangulate cube.stl -o mesh.vtu"]),
        ("m.vtu", &["septet verify m.vtu", "septet triangulate m.vtu -o mesh.vtu"]),
        ("m.pvtu", &["septet verify m.pvtu"]),
        ("m.ele", &["septet verify m.node m.ele"]),
        ("run.json", &["septet report run.json -o page.html"]),
    ] {
        let output = place.command("-q").arg(file).output().unwrap();
        let talk = stderr(&output);
        assert_eq!(code(&output), 2, "{file}: {talk}");
        assert!(talk.starts_with(&format!("error: {file} is a ")), "{talk}");
        for command in commands {
            assert!(talk.contains(command), "{file}: no `{command}`: {talk}");
            let words = command.strip_prefix("septet ").unwrap().replace(&format!("'{file}'"), "FILE");
            let words = words.split(' ').map(|word| if word == "FILE" { file } else { word });
            let output = place.command("").args(words).output().unwrap();
            assert_eq!(code(&output), 0, "{command}: {}", stderr(&output));
        }
    }
    for line in ["none", "rival points.csv", "triangel points.csv"] {
        place.fails(line, 2, &["unrecognized subcommand"]);
    }
}

/// The help opens with the uses for data, and lists the commands in the order in which a user needs them.
#[test]
fn the_help_opens_with_the_uses_for_data() {
    let place = Place::new();
    for line in ["help", "--help", "-h"] {
        let text = String::from_utf8(place.good(line).stdout).unwrap();
        assert!(text.starts_with("Turn your points into triangles or tetrahedra"), "{text}");
        let at = |command: &str| {
            text.find(&format!("\n  {command} ")).unwrap_or_else(|| panic!("{command}: {text}"))
        };
        let order = ["triangulate", "mesh", "verify", "generate", "report", "simulate", "predict"].map(at);
        assert!(order.is_sorted(), "{text}");
    }
}

/// An input without points ends with exit code 3, whatever its format is.
#[test]
fn a_surface_without_points_is_refused() {
    let place = Place::new();
    for (name, content) in [("a.obj", "# nothing\n"), ("a.stl", "solid a\nendsolid a\n")] {
        place.file(name, content);
        for options in ["", " --transport processes --processes 2"] {
            place.fails(&format!("triangulate {name}{options}"), 3, &[name]);
        }
        place.fails(&format!("simulate {name}"), 3, &[name]);
    }
}

#[test]
fn errors_name_what_is_expected() {
    let place = Place::new();
    place.file("p.xyz", SQUARE).file("cube.poly", "");
    place.fails("triangulate p.xyz -o a.vtx", 2, &[".vtu"]);
    place.fails("mesh cube.poly", 2, &["no output is given", "-o FILE", "--check"]);
    place.fails("report none.json -o a.html", 3, &["none.json: no such file", "help:"]);
    place.fails("fit none.jsonl", 3, &["none.jsonl: no such file", "help:"]);
    place.good("simulate p.xyz --json run.json");
    place.fails("fit run.json -y levels", 3, &["the report of one run", "septet scale"]);
    place.fails("fit run.json --phase hulls", 2, &["-y"]);
    place.fails("generate unifrm -n 9", 2, &["the nearest is uniform", "well-spaced"]);
    place.fails("triangulate sample:unifrm:9", 2, &["`unifrm`", "the nearest is uniform"]);
    place.fails("triangulate p.xyz -o a.x --format foo", 2, &["expected one of node", "vtu"]);
    place.fails("schema foo", 2, &["run, mesh, scale"]);
    place.fails("schema rnu", 2, &["'run'"]);
    place.fails("reproduce levls", 2, &["there is no claim `levls`", "the nearest is levels"]);
    place.fails("reproduce foo", 2, &["there is no claim `foo`", "the claims are", " levels "]);
}
