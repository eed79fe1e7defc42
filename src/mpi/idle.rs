//! Waiting without a busy processor core.

use std::thread;
use std::time::{Duration, Instant};

/// Number of checks without a sleep. Between them, the process only yields its core.
const YIELDS: u32 = 200;

/// The shortest sleep.
const SHORTEST: Duration = Duration::from_micros(50);

/// The longest sleep.
const LONGEST: Duration = Duration::from_millis(1);

/// The time that a process has waited.
#[derive(Debug)]
pub struct Idle {
    looks: u32,
    since: Instant,
}

impl Idle {
    /// Starts to wait.
    pub fn begin() -> Self {
        Idle { looks: 0, since: Instant::now() }
    }

    /// Starts again, because something arrived.
    pub fn reset(&mut self) {
        self.looks = 0;
    }

    /// Lets other processes run. A sleep is a small part of the time that the process has waited.
    pub fn rest(&mut self) {
        if self.looks == 0 {
            self.since = Instant::now();
        }
        self.looks = self.looks.saturating_add(1);
        if self.looks <= YIELDS {
            thread::yield_now();
        } else {
            thread::sleep((self.since.elapsed() / 16).clamp(SHORTEST, LONGEST));
        }
    }
}
