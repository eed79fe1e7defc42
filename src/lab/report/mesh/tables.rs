//! The tables of `septet mesh --profile`: stages of generation, phases of the machine in each stage, and runs of the
//! machine. A column contains either modelled counts or measured times.

use std::fmt::Write;

use crate::report::TableFormat;
use crate::report::tables::{Table, TableColumn};

use super::MeshReport;

/// The names of the tables, in order.
pub const TABLES: [&str; 3] = ["stages", "phases", "runs"];

impl MeshReport {
    /// Returns the tables of `--profile`: all of them, or only the table with this number in [`TABLES`].
    pub fn tables(&self, format: TableFormat, which: Option<usize>) -> String {
        let mut out = String::new();
        if format == TableFormat::Markdown {
            let _ = writeln!(out, "# mesh of {}\n", self.parameters.input);
        }
        let tables = [self.stage_table(), self.phase_table(), self.run_table()];
        for (i, table) in tables.iter().enumerate() {
            if which.is_none_or(|w| w == i) {
                table.render(format, &mut out);
            }
        }
        out
    }

    fn stage_table(&self) -> Table {
        let counts = [
            "candidates",
            "points",
            "completion rounds",
            "set rounds",
            "rounds",
            "work",
            "depth",
            "messages",
            "bytes",
        ];
        let rows = self.stages.iter().map(|s| {
            let made = [s.candidates, s.points, s.completion_rounds, s.set_rounds, s.rounds];
            let took = [s.work, s.depth, s.messages, s.bytes];
            row([s.name.clone()], made.into_iter().chain(took), s.seconds)
        });
        let s = &self.seconds;
        let note = format!(
            "{:.4} seconds reading, {:.4} making the mesh, {:.4} checking and measuring it, {:.4} writing",
            s.read_seconds, s.mesh_seconds, s.judge_seconds, s.write_seconds
        );
        let heading = ["Stages", "Stages: modelled | measured"];
        table(heading, &["stage"], &counts, rows.collect(), vec![note])
    }

    fn phase_table(&self) -> Table {
        let counts = ["runs", "rounds", "work", "depth", "messages", "bytes"];
        let rows = self.phases.iter().map(|p| {
            let counts = [p.runs, p.rounds, p.work, p.depth, p.messages, p.bytes];
            row([p.stage.clone(), p.phase.to_string()], counts, p.seconds)
        });
        let heading = ["Phases", "Phases of the machine: modelled | measured"];
        table(heading, &["stage", "phase"], &counts, rows.collect(), Vec::new())
    }

    fn run_table(&self) -> Table {
        let counts = ["points", "levels", "rounds", "work", "depth", "messages", "bytes"];
        let rows = self.runs.iter().enumerate().map(|(i, r)| {
            let levels = u64::from(r.levels);
            let counts = [r.points, levels, r.rounds, r.work, r.depth, r.messages, r.bytes];
            row([i.to_string(), r.stage.clone(), r.task.to_owned()], counts, r.seconds)
        });
        let heading = ["Runs", "Runs of the machine: modelled | measured"];
        table(heading, &["run", "stage", "task"], &counts, rows.collect(), Vec::new())
    }
}

/// Returns a row.
fn row<const N: usize>(
    labels: [String; N],
    counts: impl IntoIterator<Item = u64>,
    seconds: f64,
) -> Vec<String> {
    let counts = counts.into_iter().map(|c| c.to_string());
    labels.into_iter().chain(counts).chain([format!("{seconds:.4}")]).collect()
}

/// Returns a table of labels, counts and measured seconds.
fn table(
    [title, heading]: [&'static str; 2],
    labels: &[&'static str],
    counts: &[&'static str],
    rows: Vec<Vec<String>>,
    notes: Vec<String>,
) -> Table {
    let columns =
        labels.iter().map(|&l| TableColumn::Label(l)).chain(counts.iter().map(|&c| TableColumn::Modelled(c)));
    let columns = columns.chain([TableColumn::Measured("seconds")]).collect();
    Table { title, heading, columns, rows, totals: Vec::new(), notes }
}
