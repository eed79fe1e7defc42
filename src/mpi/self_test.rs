//! The test of the wire, by the processes themselves.
//!
//! `--self-test` exchanges parcels of many lengths between all processes and between the first ones. All processes compute
//! from one function the parcels that they send and those that must arrive. `--self-test=hang` exchanges parcels until
//! a process is killed. `panic` and `fail` end one process, and `large` sends a parcel of more than 2 GiB.

use std::process::{self, ExitCode};
use std::thread;
use std::time::{Duration, Instant};

use septet_protocol::wire::{Arrived, Parcel, PartBytes, Wire, WireError};

use crate::wire::MpiWire;

/// The number of exchanges.
const ROUNDS: u64 = 200;

/// The bytes of a part in most rounds, so that many parcels have several parts.
const SMALL_PART: usize = 4096;

/// The length of a long parcel.
const LONG: usize = 3_000_000;

/// A parcel that MPI cannot send as one message.
const TOO_LONG: usize = (1 << 31) + 5;

/// The process that fails in the tests of failures fails in this round.
const FAILS_IN: u64 = 50;

/// The time after which `hang` stops by itself.
const LIMIT: Duration = Duration::from_mins(1);

/// The test that the arguments ask for, such as `hang`. It is empty for the test of parcels.
pub fn asked() -> Option<String> {
    let first = std::env::args().nth(1)?;
    let rest = first.strip_prefix("--self-test")?;
    Some(rest.trim_start_matches('=').to_string())
}

/// Runs a test. Process 0 prints the result.
pub fn run(test: &str, wire: &mut MpiWire) -> ExitCode {
    let (process, last) = (wire.process(), wire.processes() - 1);
    let result = match test {
        "" => (0..ROUNDS).try_for_each(|round| check(wire, round)),
        "hang" => hang(wire),
        "large" => large(wire),
        "panic" | "fail" => {
            for round in 0..ROUNDS {
                if process == last && round == FAILS_IN {
                    assert!(test != "panic", "this panic is planted");
                    eprintln!("this failure is planted");
                    return ExitCode::from(7);
                }
                if let Err(error) = check(wire, round) {
                    return failed(process, &error);
                }
            }
            Ok(())
        }
        _ => {
            eprintln!("there is no test {test}");
            return ExitCode::from(2);
        }
    };
    match result {
        Ok(()) if process == 0 => println!("passed"),
        Ok(()) => {}
        Err(error) => return failed(process, &error),
    }
    ExitCode::SUCCESS
}

fn failed(process: u32, error: &WireError) -> ExitCode {
    eprintln!("process {process}: {error}");
    ExitCode::from(6)
}

/// Prints the ids of all processes, and exchanges parcels until the time is over.
fn hang(wire: &mut MpiWire) -> Result<(), WireError> {
    println!("id {}", process::id());
    let start = Instant::now();
    let mut round = 0;
    loop {
        check(wire, round)?;
        round += 1;
        let is_over = start.elapsed() > LIMIT;
        if wire.exchange(wire.processes(), Vec::new(), u8::from(is_over))?.state > 0 {
            return Ok(());
        }
    }
}

/// Sends a parcel of more than 2^31 bytes from process 0 to the last one.
fn large(wire: &mut MpiWire) -> Result<(), WireError> {
    let last = wire.processes() - 1;
    let bytes: Vec<u8> = (0..TOO_LONG).map(|at| (at / 1021) as u8).collect();
    let sent =
        if wire.process() == 0 && last > 0 { vec![Parcel { process: last, bytes }] } else { Vec::new() };
    let arrived = wire.exchange(wire.processes(), sent, 0)?.parcels;
    assert_eq!(
        arrived.len(),
        usize::from(wire.process() == last && last > 0),
        "a parcel too many or too few"
    );
    for parcel in arrived {
        assert_eq!(parcel.bytes.len(), TOO_LONG, "the parcel has another length");
        assert!(
            parcel.bytes.iter().enumerate().all(|(at, &byte)| byte == (at / 1021) as u8),
            "bytes changed"
        );
    }
    Ok(())
}

/// Exchanges the parcels of a round, and compares those that arrive.
fn check(wire: &mut MpiWire, round: u64) -> Result<(), WireError> {
    let (process, processes) = (wire.process(), wire.processes());
    let drawn = random([round, 1, 0, 0]);
    let members = if drawn.is_multiple_of(3) { 1 + (drawn >> 8) as u32 % processes } else { processes };
    if process >= members {
        return Ok(());
    }
    let small = PartBytes::new(SMALL_PART as u64).expect("a possible number");
    wire.set_part_bytes(if round % 4 == 3 { PartBytes::default() } else { small });
    let delay = random([round, 2, process.into(), 0]);
    if delay.is_multiple_of(16) {
        thread::sleep(Duration::from_micros((delay >> 8) % 3000));
    }
    let others = || (0..members).filter(|&other| other != process);
    let mut sent: Vec<Parcel> = others()
        .filter_map(|to| Some(Parcel { process: to, bytes: content(round, process, to, processes)? }))
        .collect();
    if round % 2 == 1 {
        sent.reverse();
    }
    let expected = Arrived {
        parcels: others()
            .filter_map(|of| Some(Parcel { process: of, bytes: content(round, of, process, processes)? }))
            .collect(),
        state: (0..members).map(|of| state(round, of)).max().expect("a member"),
    };
    let arrived = wire.exchange(members, sent, state(round, process))?;
    let of = |arrived: &Arrived| -> Vec<(u32, usize)> {
        arrived.parcels.iter().map(|parcel| (parcel.process, parcel.bytes.len())).collect()
    };
    assert_eq!(of(&arrived), of(&expected), "senders and lengths in round {round}");
    assert_eq!(arrived.state, expected.state, "the state of round {round}");
    assert!(arrived == expected, "bytes of round {round} changed");
    Ok(())
}

fn state(round: u64, process: u32) -> u8 {
    (random([round, 3, process.into(), 0]) % 256) as u8
}

/// The content of a parcel, if there is one.
fn content(round: u64, from: u32, to: u32, processes: u32) -> Option<Vec<u8>> {
    let drawn = random([round, 4, from.into(), to.into()]);
    let long = round.is_multiple_of(40) && u64::from(from) == round / 40 % u64::from(processes);
    let (short, parts) = ((drawn >> 8) as usize % 100, (drawn >> 16) as usize % 5);
    let len = match drawn % 8 {
        _ if long => LONG,
        0..=2 => return None,
        3 => 0,
        4 | 5 => short,
        6 => (parts * SMALL_PART + short % 20).saturating_sub(10),
        _ => parts * SMALL_PART,
    };
    let mut bytes = Vec::with_capacity(len + 8);
    let mut at = 0;
    while bytes.len() < len {
        bytes.extend_from_slice(&random([drawn, 5, at, 0]).to_le_bytes());
        at += 1;
    }
    bytes.truncate(len);
    Some(bytes)
}

/// A number that looks random: four steps of `SplitMix64`.
fn random(of: [u64; 4]) -> u64 {
    of.into_iter().fold(0, |state: u64, word| {
        let mut z = (state ^ word).wrapping_add(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    })
}
