//! What a run says while it goes on: a bar, notes, log lines; and how it is interrupted.

use std::io::IsTerminal;
use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use septet_core::config::{Progress, ProgressFn};
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;
use tracing_subscriber::{Layer, Registry};

/// Options of every subcommand about what is said.
#[derive(Debug, Args)]
pub struct TalkArgs {
    /// Say nothing but errors
    #[arg(short, long, global = true, conflicts_with = "verbose", display_order = 100)]
    quiet: bool,
    /// Log phases (-v), and more (-vv); `RUST_LOG` overrides
    #[arg(short, long, global = true, action = clap::ArgAction::Count, display_order = 100)]
    verbose: u8,
    /// Colours on standard error: on a terminal without `NO_COLOR`, always, or never
    #[arg(long, global = true, value_name = "WHEN", default_value = "auto", display_order = 100)]
    color: When,
}

/// When to use colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum When {
    Auto,
    Always,
    Never,
}

/// The payload that ends work from within a progress callback: everything on the way is dropped, half-written
/// files with it.
pub struct Cancelled;

/// How the program speaks.
pub struct Talk {
    quiet: bool,
    color: bool,
    /// What is logged unless `RUST_LOG` says otherwise.
    filter: Targets,
    bar: ProgressBar,
    /// Set by the first Ctrl-C.
    pub cancel: Arc<AtomicBool>,
}

impl Talk {
    /// Sets up the bar and the interrupt handler.
    pub fn new(args: &TalkArgs) -> Self {
        let terminal = std::io::stderr().is_terminal();
        let color = match args.color {
            When::Always => true,
            When::Never => false,
            When::Auto => terminal && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty()),
        };
        let level = match (args.quiet, args.verbose) {
            (true, _) => LevelFilter::ERROR,
            (_, 0) => LevelFilter::WARN,
            (_, 1) => LevelFilter::INFO,
            (_, 2) => LevelFilter::DEBUG,
            _ => LevelFilter::TRACE,
        };
        let filter = Targets::new().with_default(level);
        // The lines say which phase it is.
        let filter = if level == LevelFilter::INFO {
            filter.with_target("septet::phase", LevelFilter::OFF)
        } else {
            filter
        };
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
        if terminal && !args.quiet && args.verbose == 0 {
            bar.set_draw_target(ProgressDrawTarget::stderr_with_hz(10));
            // Long steps say nothing: the clock goes on all the same.
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
        let (flag, quiet, shown) = (cancel.clone(), args.quiet, bar.clone());
        // Without a handler the first Ctrl-C kills, which is no worse than no program at all.
        let _ = ctrlc::set_handler(move || {
            if flag.swap(true, Ordering::SeqCst) {
                std::process::exit(130);
            }
            if !quiet {
                shown.suspend(|| {
                    eprintln!("interrupted: ending at the next step (once more to end at once)");
                });
            }
        });
        Talk { quiet: args.quiet, color, filter, bar, cancel }
    }

    /// Sets up logging, and a trace if there is one; it can be done only once.
    pub fn log<L>(&self, trace: Option<L>)
    where
        L: Layer<Registry> + Send + Sync,
    {
        let asked = std::env::var("RUST_LOG").ok().filter(|text| !text.is_empty());
        let filter: Targets = asked.and_then(|text| text.parse().ok()).unwrap_or_else(|| self.filter.clone());
        let lines = tracing_subscriber::fmt::layer().with_writer(std::io::stderr).with_ansi(self.color);
        // A second subscriber cannot be there yet; if it were, it would serve as well.
        let _ = tracing_subscriber::registry().with(trace).with(lines.with_filter(filter)).try_init();
    }

    /// Text in a colour, if there are colours.
    pub fn paint(&self, text: &str, code: &str) -> String {
        if self.color { format!("\x1b[{code}m{text}\x1b[0m") } else { text.to_owned() }
    }

    /// One line on standard error, unless quiet.
    pub fn note(&self, line: impl AsRef<str>) {
        if !self.quiet {
            self.bar.suspend(|| eprintln!("{}", line.as_ref()));
        }
    }

    /// Writes something else while the bar stands aside.
    pub fn aside(&self, write: impl FnOnce()) {
        self.bar.suspend(write);
    }

    /// One line on standard error, even if quiet: what is wrong with the input.
    pub fn fault(&self, line: impl AsRef<str>) {
        self.bar.suspend(|| eprintln!("{}", line.as_ref()));
    }

    /// Shows how far a stage is, and ends the work here if it was interrupted.
    pub fn stage(&self, name: &str, done: u64, total: Option<u64>) {
        self.check();
        self.bar.set_message(name.to_owned());
        if let Some(total) = total {
            self.bar.set_length(total.max(1));
            self.bar.set_position(done);
        } else {
            self.bar.unset_length();
            self.bar.tick();
        }
    }

    /// Ends the work here if it was interrupted.
    pub fn check(&self) {
        if self.cancel.load(Ordering::Relaxed) {
            resume_unwind(Box::new(Cancelled));
        }
    }

    /// Takes the bar away.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }

    /// The callback of a run: the bar, and a log line at the end of every phase.
    pub fn phases(&self) -> ProgressFn {
        let bar = self.bar.clone();
        let last: Mutex<Option<(&'static str, Instant)>> = Mutex::new(None);
        Arc::new(move |p: Progress| {
            bar.set_length(p.position.1 as u64);
            bar.set_position(p.position.0 as u64);
            bar.set_message(match p.phase {
                // What follows the last round is the canonical order of the cells.
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
