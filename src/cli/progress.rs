//! The progress bar, notes and log lines of a running command, and the handling of Ctrl-C.

use std::io::{IsTerminal, Write, stderr};
use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use septet_core::spec::{Progress, ProgressFn};
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;
use tracing_subscriber::{Layer, Registry};

use super::text::printable;

/// The options for messages, which every subcommand has.
#[derive(Debug, Args)]
pub struct TalkArgs {
    /// Print errors only
    #[arg(short, long, global = true, conflicts_with = "verbose", display_order = 100, help_heading = MESSAGES)]
    quiet: bool,
    /// Log phases, and more if repeated
    ///
    /// The environment variable `RUST_LOG` overrides this option.
    #[arg(short, long, global = true, action = clap::ArgAction::Count, display_order = 100, help_heading = MESSAGES)]
    verbose: u8,
    /// Use colours on standard error
    #[arg(long, global = true, value_name = "WHEN", default_value = "auto", display_order = 100, help_heading = MESSAGES, hide_short_help = true)]
    color: When,
}

/// The heading of these options.
const MESSAGES: &str = "Messages";

/// Values of `--color`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum When {
    /// On a terminal, unless `NO_COLOR` is set
    Auto,
    /// Always
    Always,
    /// Never
    Never,
}

/// The panic payload that ends a command from within a progress callback. Unwinding removes partial files.
pub struct Cancelled;

/// The messages of the program.
pub struct Talk {
    quiet: bool,
    /// Whether another process reports the errors of this one.
    is_silent: bool,
    color: bool,
    /// The log filter without `RUST_LOG`.
    filter: Targets,
    bar: ProgressBar,
    /// Set by the first Ctrl-C.
    pub cancel: Arc<AtomicBool>,
}

impl Talk {
    /// Sets up the bar and the interrupt handler. A silent process prints nothing, because another one reports its errors.
    pub fn new(args: &TalkArgs, is_silent: bool) -> Self {
        let terminal = stderr().is_terminal() && !is_silent;
        let is_quiet = args.quiet || is_silent;
        let color = match args.color {
            When::Always => true,
            When::Never => false,
            When::Auto => terminal && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty()),
        };
        let level = match (is_quiet, args.verbose) {
            (true, _) => LevelFilter::ERROR,
            (_, 0) => LevelFilter::WARN,
            (_, 1) => LevelFilter::INFO,
            (_, 2) => LevelFilter::DEBUG,
            _ => LevelFilter::TRACE,
        };
        let filter = Targets::new().with_default(level);
        // The log lines name the phase, so its span is not needed.
        let filter = if level == LevelFilter::INFO {
            filter.with_target("septet_lab::phase", LevelFilter::OFF)
        } else {
            filter
        };
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
        if terminal && !is_quiet && args.verbose == 0 {
            bar.set_draw_target(ProgressDrawTarget::stderr_with_hz(10));
            bar.set_message("starting");
            // The clock also runs during steps that report no progress.
            bar.enable_steady_tick(Duration::from_millis(100));
        }
        let template = if color {
            "{spinner:.cyan} {msg:<34} [{bar:30.cyan/blue}] {percent:>3}% {elapsed}"
        } else {
            "{spinner} {msg:<34} [{bar:30}] {percent:>3}% {elapsed}"
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.progress_chars("=> "));
        }
        let cancel = Arc::new(AtomicBool::new(false));
        let (flag, quiet, shown) = (cancel.clone(), is_quiet, bar.clone());
        // If setting the handler fails, the first Ctrl-C kills the process.
        let _ = ctrlc::set_handler(move || {
            if flag.swap(true, Ordering::SeqCst) {
                std::process::exit(130);
            }
            if !quiet {
                shown.suspend(|| {
                    let _ = writeln!(
                        stderr(),
                        "interrupted: stopping at the next step (press again to exit now)"
                    );
                });
            }
        });
        Talk { quiet: is_quiet, is_silent, color, filter, bar, cancel }
    }

    /// Returns `true` if another process reports the errors of this one.
    pub fn is_silent(&self) -> bool {
        self.is_silent
    }

    /// Sets up logging and the trace, if any. Only the first call has an effect.
    pub fn log<L>(&self, trace: Option<L>)
    where
        L: Layer<Registry> + Send + Sync,
    {
        let asked = std::env::var("RUST_LOG").ok().filter(|text| !text.is_empty());
        let filter: Targets = asked.and_then(|text| text.parse().ok()).unwrap_or_else(|| self.filter.clone());
        let lines = tracing_subscriber::fmt::layer().with_writer(std::io::stderr).with_ansi(self.color);
        // This fails only if a subscriber is already set.
        let _ = tracing_subscriber::registry().with(trace).with(lines.with_filter(filter)).try_init();
    }

    /// Colours text if colours are on.
    pub fn paint(&self, text: &str, code: &str) -> String {
        if self.color { format!("\x1b[{code}m{text}\x1b[0m") } else { text.to_owned() }
    }

    /// Prints a line to standard error, unless quiet. Control characters are escaped.
    pub fn note(&self, line: impl AsRef<str>) {
        self.painted(printable(line.as_ref()));
    }

    /// Prints a line that contains colours to standard error, unless quiet.
    pub fn painted(&self, line: impl AsRef<str>) {
        if !self.quiet {
            self.fault(line);
        }
    }

    /// Hides the bar while `write` runs.
    pub fn aside(&self, write: impl FnOnce()) {
        self.bar.suspend(write);
    }

    /// Prints a line about a defect of the input to standard error, even if quiet.
    pub fn fault(&self, line: impl AsRef<str>) {
        // Nothing can be reported if standard error is closed.
        self.bar.suspend(|| drop(writeln!(stderr(), "{}", line.as_ref())));
    }

    /// Shows the progress of a stage. Ends the command if Ctrl-C was pressed.
    pub fn stage(&self, name: &str, done: u64, total: Option<u64>) {
        self.check();
        self.show(name, done, total);
    }

    /// Shows the progress of a stage.
    pub fn show(&self, name: &str, done: u64, total: Option<u64>) {
        self.bar.set_message(printable(name));
        if let Some(total) = total {
            self.bar.set_length(total.max(1));
            self.bar.set_position(done);
        } else {
            self.bar.unset_length();
            self.bar.tick();
        }
    }

    /// Returns `true` if Ctrl-C was pressed.
    pub fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }

    /// Ends the command if Ctrl-C was pressed.
    pub fn check(&self) {
        if self.is_cancelled() {
            resume_unwind(Box::new(Cancelled));
        }
    }

    /// Removes the bar.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }

    /// Returns the progress callback of a run, which moves the bar and logs the end of every phase.
    pub fn phases(&self) -> ProgressFn {
        let bar = self.bar.clone();
        let last: Mutex<Option<(&'static str, Instant)>> = Mutex::new(None);
        Arc::new(move |p: Progress| {
            bar.set_length(p.position.1 as u64);
            bar.set_position(p.position.0 as u64);
            bar.set_message(match p.phase {
                // The cells are brought into canonical order after the last round.
                "done" => "ordering cells".to_owned(),
                phase => format!("{phase}, round {}", p.round),
            });
            let Ok(mut last) = last.lock() else { return };
            match *last {
                Some((phase, _)) if phase == p.phase => {}
                before => {
                    if let Some((phase, since)) = before {
                        let seconds = since.elapsed().as_secs_f64();
                        tracing::info!(phase, round = p.round, seconds, "phase ended");
                    }
                    *last = Some((p.phase, Instant::now()));
                }
            }
        })
    }
}
