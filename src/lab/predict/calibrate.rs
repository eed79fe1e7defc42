//! The hardware parameters of this computer, measured by a run and by channels between threads.

use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, Sender, unbounded};

use septet_core::Outcome;
use septet_protocol::ids::Phase;

use super::hardware::Hardware;

/// Charged work and measured seconds of a phase.
#[derive(Clone, Copy, Debug)]
struct TimedPhase {
    phase: Phase,
    work: u64,
    seconds: f64,
}

/// Returns the charged work and the measured seconds of each phase of a run.
fn timed(run: &Outcome) -> Vec<TimedPhase> {
    let totals = &run.ledger.phases;
    let work = |phase| totals.iter().find(|total| total.phase == phase).map_or(0, |total| total.work);
    let row = |&(phase, seconds): &(Phase, f64)| TimedPhase { phase, work: work(phase), seconds };
    run.times.phases.iter().map(row).collect()
}

const BOUNCES: u32 = 2000;
const SMALL: usize = 64;
const LARGE: usize = 1 << 23;
const TRIALS: usize = 5;

type Line = (Sender<Vec<u8>>, Receiver<Vec<u8>>);

/// Measures one exchange with another thread: fills a buffer of `bytes` bytes, sends it, and receives a copy of it.
/// Returns the seconds, or `None` if no copy arrives within ten seconds.
fn bounce(out: &Sender<Vec<u8>>, back: &Receiver<Vec<u8>>, bytes: usize) -> Option<f64> {
    let start = Instant::now();
    out.send(vec![1; bytes]).ok()?;
    let echo = back.recv_timeout(Duration::from_secs(10)).ok()?;
    Some(start.elapsed().as_secs_f64() + if echo.len() == bytes { 0.0 } else { f64::INFINITY })
}

fn median(mut all: Vec<f64>) -> f64 {
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(0.0)
}

/// Measures latency, overhead and bandwidth of channels between two threads. Rates come from the phases of `run`, which
/// must be a run with one worker on one thread. A phase without charged work is assumed to take the same time for every
/// number of workers.
pub fn calibrate(run: &Outcome) -> Hardware {
    let phases = timed(run);
    let (out, inbox): Line = unbounded();
    let (reply, back): Line = unbounded();
    let echo = std::thread::spawn(move || {
        for buffer in inbox {
            // The copy reads the bytes, because reading is part of the transfer.
            let copy = buffer.clone();
            if reply.send(copy).is_err() {
                return;
            }
        }
    });
    let small = median((0..BOUNCES).filter_map(|_| bounce(&out, &back, SMALL)).collect());
    let large = median((0..TRIALS).filter_map(|_| bounce(&out, &back, LARGE)).collect());
    drop(out);
    // The thread ends when the channel closes, and does not panic.
    let _ = echo.join();
    let usual = Hardware::default();
    let one_way = small / 2.0;
    let mut hardware = Hardware { latency: one_way, overhead: one_way / 2.0, ..usual };
    if large > small {
        hardware.bandwidth = 2.0 * LARGE as f64 / (large - small);
    }
    let timed = phases.iter().filter(|t| t.work > 0 && t.seconds > 0.0);
    hardware.phase_rates = timed.map(|t| (t.phase.name().to_owned(), t.work as f64 / t.seconds)).collect();
    let (work, seconds) = phases.iter().fold((0, 0.0), |s, t| (s.0 + t.work, s.1 + t.seconds));
    if work > 0 && seconds > 0.0 {
        hardware.rate = work as f64 / seconds;
    }
    hardware.fixed = phases.iter().filter(|t| t.work == 0).map(|t| t.seconds).sum();
    hardware
}
