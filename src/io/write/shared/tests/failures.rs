//! Refused outputs and failing writes.

use std::io::{ErrorKind, Write};

use septet_common::sets::plane;
use septet_core::WorkerShare;
use septet_core::generate::Kind;
use septet_protocol::wire::Refused;

use super::*;
use crate::format::Format;

fn shares() -> Vec<Own> {
    apart(&Points::Plane(plane(Kind::Uniform, 300, 3)), 5, 3)
}

/// The largest subdomain of a process.
fn largest(own: &mut Own) -> &mut WorkerShare {
    own.run.shares.iter_mut().max_by_key(|subdomain| subdomain.cell_count()).unwrap()
}

/// Checks outputs on three processes, which refuse them.
fn check_refused(outputs: &[PathBuf], options: &WriteOptions<'_>) -> Refused {
    refused(on_each(&shares(), |processes, _| check_shared(processes, outputs, options)))
}

#[test]
fn formats_and_options_are_refused_by_name() {
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str| vec![directory.path().join(name)];
    let plain = WriteOptions::default();
    for (outputs, code, words) in [
        (at("m.vut"), 2, "the nearest is .vtu"),
        (at("m.pvtu.gz"), 2, "omit .gz"),
        (at("none/m.vtu"), 1, "create the directory"),
        ([at("m.npy"), at("./m.npy")].concat(), 2, "the same file"),
    ] {
        let Refused { code: found, message, remedy, .. } = check_refused(&outputs, &plain);
        assert!(found == code && (message.contains(words) || remedy.contains(words)), "{found} {message}");
        assert!(message.contains(outputs[0].to_str().unwrap()), "{message}");
    }
    let npy = WriteOptions { format: Some(Format::Npy), ..plain };
    assert!(check_refused(&["-".into()], &npy).message.contains("a stream or a device"));
    #[cfg(unix)]
    assert!(check_refused(&["/dev/null".into()], &npy).message.contains("a stream or a device"));
    let good = on_each(&shares(), |processes, _| check_shared(processes, &outputs(directory.path()), &plain));
    assert!(good.into_iter().all(|result| result.is_ok()));
    assert!(files(directory.path()).is_empty());
}

#[test]
fn processes_with_other_folders_or_outputs_are_named() {
    let directories = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let options = WriteOptions::default();
    for (names, code, words) in [
        (["m.vtu"; 2], 1, "process 2 does not see the folder"),
        (["m.vtu", "n.vtu"], 2, "process 2 has other outputs"),
    ] {
        let check = |processes: &mut Processes<'_>, _: &Own| {
            let which = usize::from(processes.process() == 2);
            check_shared(processes, &[directories[which].path().join(names[which])], &options)
        };
        let Refused { process, code: found, message, .. } = refused(on_each(&shares(), check));
        assert!(process == 2 && found == code && message.contains(words), "{found} {message}");
        assert!(directories.iter().all(|directory| files(directory.path()).is_empty()));
    }
}

/// Writes on three processes, one of which spoils its share or the folder before. Returns the refusal.
fn write_spoilt(directory: &Path, outputs: &[PathBuf], spoil: impl Fn(&mut Own)) -> Refused {
    fs::create_dir(directory.join("m.pieces")).unwrap();
    fs::write(directory.join("m.pieces/0000.vtu"), "old").unwrap();
    fs::write(directory.join("m.npy"), "old").unwrap();
    let before = files(directory);
    let mut owns = shares();
    spoil(&mut owns[1]);
    let write = |processes: &mut Processes<'_>, own: &Own| {
        write_shared(processes, outputs, &own.mesh(), &WriteOptions::default(), &|| false)
    };
    let refused = refused(on_each(&owns, write));
    assert!(files(directory) == before, "{refused:?}: {:?}", files(directory).keys());
    refused
}

#[test]
fn shares_that_contradict_each_other_leave_nothing() {
    type Spoil = fn(&mut Own);
    let spoilt: [(&str, Spoil); 6] = [
        ("not consecutive", |own| own.first += 1),
        ("of other workers", |own| own.run.shares.truncate(1)),
        ("different lengths", |own| largest(own).owners.truncate(1)),
        ("have other owners", |own| largest(own).owners[0] = 9),
        ("point 300 of points 0 to 300", |own| largest(own).ids[0] = 300),
        ("cells", |own| own.run.facts.cells += 1),
    ];
    for (words, spoil) in spoilt {
        let directory = tempfile::tempdir().unwrap();
        let Refused { code, message, .. } = write_spoilt(directory.path(), &outputs(directory.path()), spoil);
        assert!(code == 1 && message.contains(words), "{message}");
    }
}

/// The pieces fail after the ranges of other outputs are written.
#[test]
fn a_failure_after_other_files_leaves_nothing() {
    let directory = tempfile::tempdir().unwrap();
    // An owned point, which other processes send as a vertex of ghost cells, takes the number of another.
    let spoil = |own: &mut Own| {
        let own = largest(own);
        own.ids[0] = own.ids[1];
    };
    let refused = write_spoilt(directory.path(), &outputs(directory.path()), spoil);
    assert!(refused.message.contains("is missing"), "{refused:?}");
}

/// The disk of process 2 is full.
#[test]
fn a_failing_write_leaves_nothing() {
    let directory = tempfile::tempdir().unwrap();
    let results = on_each(&shares(), |processes, _| {
        let mut staged = Staged::default();
        let process = processes.process();
        staged.write_range(processes, &directory.path().join("a.npy"), |place| {
            place.go_to(process as usize)?;
            place.write_all(b"a")
        })?;
        staged.write_range(processes, &directory.path().join("b.npy"), |place| {
            assert_eq!(place.is_first, process == 0);
            if process == 2 { Err(ErrorKind::StorageFull.into()) } else { Ok(()) }
        })
    });
    let Refused { process, code, message, remedy } = refused(results);
    assert!(process == 2 && code == 1 && message.contains("b.npy"), "{message}");
    assert_eq!(remedy, "check the free space on the disk");
    assert!(files(directory.path()).is_empty());
}

/// The last rename fails, because a folder has the name of a file.
#[test]
fn a_failing_rename_leaves_nothing() {
    let directory = tempfile::tempdir().unwrap();
    fs::create_dir(directory.path().join("m.pieces")).unwrap();
    let owns = shares();
    let before = files(directory.path());
    let mut staged = Staged::default();
    staged.stage.reserve(&directory.path().join("m.npy")).unwrap();
    staged.stage.reserve(&directory.path().join("m.vtu")).unwrap();
    let made = on_each(&owns[..1], |processes, _| {
        let mut staged = Staged::default();
        staged.create_folder(processes, &directory.path().join("m.pvtu"), 3)?;
        staged.stage.reserve(&directory.path().join("x.npy")).unwrap();
        fs::create_dir(directory.path().join("x.npy")).unwrap();
        Ok(staged.commit().map_err(|error| error.to_string()))
    });
    assert!(made[0].as_ref().unwrap().as_ref().unwrap_err().contains("is a directory"));
    fs::remove_dir(directory.path().join("x.npy")).unwrap();
    drop(staged);
    assert_eq!(files(directory.path()), before);
}

/// In `/proc`, even the superuser cannot create files.
#[cfg(target_os = "linux")]
#[test]
fn a_folder_that_is_not_writable_is_refused() {
    let refused = check_refused(&["/proc/m.npy".into()], &WriteOptions::default());
    assert!(refused.code == 1 && refused.message.contains("cannot be written"), "{refused:?}");
}
