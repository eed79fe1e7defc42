//! The report as tables of phases, rounds and tree levels, in aligned text, Markdown or CSV. A column contains either
//! modelled counts or measured times. Its name states the kind.

use std::fmt::Write;

use septet_protocol::ids::Group;
use septet_protocol::ledger::{RoundRow, RoundTally, Total};

use super::schema::{LevelDepths, RunReport};
use crate::rows::LevelRow;

/// The format of tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableFormat {
    /// Aligned columns, with a bar between modelled and measured ones.
    Text,
    /// Markdown tables under headings.
    Markdown,
    /// CSV according to RFC 4180, with one header row and no totals. An entry that was not counted is empty. Each
    /// file has one table.
    Csv,
}

/// The kind of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TableColumn {
    /// The label of the row.
    Label(&'static str),
    /// A count of the machine.
    Modelled(&'static str),
    /// A measured time.
    Measured(&'static str),
}

/// The text of a cell. Empty if the value was not counted.
type Cell = String;

/// A table.
pub(crate) struct Table {
    pub(crate) title: &'static str,
    /// The heading in aligned text.
    pub(crate) heading: &'static str,
    pub(crate) columns: Vec<TableColumn>,
    pub(crate) rows: Vec<Vec<Cell>>,
    /// Rows of sums; omitted in CSV.
    pub(crate) totals: Vec<Vec<Cell>>,
    /// Lines below the table; omitted in CSV.
    pub(crate) notes: Vec<String>,
}

fn maybe(x: Option<u64>) -> Cell {
    x.map_or_else(String::new, |x| x.to_string())
}

fn ratio(x: Option<f64>) -> Cell {
    x.map_or_else(String::new, |x| format!("{x:.3}"))
}

/// Returns a cell as it is shown in text and Markdown.
fn shown(cell: &str) -> &str {
    if cell.is_empty() { "-" } else { cell }
}

impl TableColumn {
    fn name(self) -> &'static str {
        match self {
            TableColumn::Label(name) | TableColumn::Modelled(name) | TableColumn::Measured(name) => name,
        }
    }

    /// Returns the name with the kind of the column.
    fn full_name(self) -> String {
        match self {
            TableColumn::Label(name) => name.to_owned(),
            TableColumn::Modelled(name) => format!("modelled {name}"),
            TableColumn::Measured(name) => format!("measured {name}"),
        }
    }
}

impl Table {
    pub(crate) fn render(&self, format: TableFormat, out: &mut String) {
        match format {
            TableFormat::Text => self.text(out),
            TableFormat::Markdown => self.markdown(out),
            TableFormat::Csv => self.csv(out),
        }
    }

    /// Writes aligned text: the first column left-aligned, the others right-aligned.
    fn text(&self, out: &mut String) {
        let _ = writeln!(out, "\n{}", self.heading);
        let barred = |cells: Vec<String>| {
            let mut line = Vec::new();
            for (cell, column) in cells.into_iter().zip(&self.columns) {
                if matches!(column, TableColumn::Measured(_)) && !line.iter().any(|c| c == "|") {
                    line.push("|".to_owned());
                }
                line.push(cell);
            }
            line
        };
        let head = barred(self.columns.iter().map(|c| c.name().to_owned()).collect());
        let rows = self.rows.iter().map(|r| r.iter().map(|c| shown(c).to_owned()).collect());
        let totals = self.totals.iter().cloned();
        let lines: Vec<Vec<String>> = std::iter::once(head).chain(rows.chain(totals).map(barred)).collect();
        let width = |c: usize| lines.iter().map(|l| l[c].chars().count()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..lines[0].len()).map(width).collect();
        for line in &lines {
            let mut text = format!("{:<1$}", line[0], widths[0]);
            for (cell, width) in line.iter().zip(&widths).skip(1) {
                let _ = write!(text, "  {cell:>width$}");
            }
            let _ = writeln!(out, "{}", text.trim_end());
        }
        for note in &self.notes {
            let _ = writeln!(out, "{note}");
        }
    }

    fn markdown(&self, out: &mut String) {
        let row = |cells: &mut dyn Iterator<Item = String>| {
            let cells: Vec<String> = cells.map(|c| c.replace('|', "\\|")).collect();
            format!("| {} |\n", cells.join(" | "))
        };
        let _ = writeln!(out, "## {}\n", self.title);
        out.push_str(&row(&mut self.columns.iter().map(|c| c.full_name())));
        let rule =
            |c: &TableColumn| if matches!(c, TableColumn::Label(_)) { "---" } else { "---:" }.to_owned();
        out.push_str(&row(&mut self.columns.iter().map(rule)));
        for cells in &self.rows {
            out.push_str(&row(&mut cells.iter().map(|c| shown(c).to_owned())));
        }
        for cells in &self.totals {
            out.push_str(&row(&mut cells.iter().cloned()));
        }
        out.push('\n');
        for note in &self.notes {
            let _ = writeln!(out, "{note}\n");
        }
    }

    fn csv(&self, out: &mut String) {
        let quoted = |c: &str| {
            if c.contains([',', '"', '\n']) {
                format!("\"{}\"", c.replace('"', "\"\""))
            } else {
                c.to_owned()
            }
        };
        let head: Vec<String> = self.columns.iter().map(|c| c.full_name().replace(' ', "_")).collect();
        let _ = writeln!(out, "{}", head.join(","));
        for row in &self.rows {
            let cells: Vec<String> = row.iter().map(|c| quoted(c)).collect();
            let _ = writeln!(out, "{}", cells.join(","));
        }
    }
}

impl RunReport {
    /// Returns the tables of `--profile` (phases, rounds and tree levels): all of them, or only the table with this
    /// number.
    pub fn tables(&self, format: TableFormat, which: Option<usize>) -> String {
        let mut out = String::new();
        if format == TableFormat::Markdown {
            let n = self.points.used;
            let _ = writeln!(out, "# {} of {n} points\n", self.parameters.command);
        }
        let tables = [self.phase_table(format), self.round_table(), self.level_table()];
        for (i, table) in tables.iter().enumerate() {
            if which.is_none_or(|w| w == i) {
                table.render(format, &mut out);
            }
        }
        out
    }

    /// Returns the totals of the groups of phases, without those of groups that no phase of the run belongs to.
    fn totals(&self) -> impl Iterator<Item = (Group, &Total<Option<u64>>)> {
        let has = |group| self.phases.iter().any(|phase| phase.group() == group);
        let totals = self.machine.totals.each().into_iter().map(|(group, row)| (group, &row.total));
        totals.filter(move |&(group, total)| total.work.is_some() && has(group))
    }

    fn phase_table(&self, format: TableFormat) -> Table {
        use TableColumn::{Label, Measured, Modelled};
        let mut columns = vec![Label("phase")];
        // In aligned text, an asterisk at the names of phases outside of the paper replaces the column `group`.
        let starred = format == TableFormat::Text;
        if !starred {
            columns.push(Label("group"));
        }
        columns.extend(
            ["rounds", "work", "exact tests", "depth", "critical", "messages", "bytes"].map(Modelled),
        );
        columns.push(Measured("seconds"));
        let mut rows = Vec::new();
        for p in &self.phases {
            let (own, t) = (p.group() == Group::Paper, &p.total);
            let mut row = vec![format!("{}{}", p.name(), if own || !starred { "" } else { " *" })];
            if !starred {
                row.push(p.group().name().to_owned());
            }
            row.extend([t.rounds.to_string(), maybe(t.work), maybe(t.exact_tests)]);
            row.extend([maybe(t.depth), maybe(t.critical_depth)]);
            row.extend([t.messages.to_string(), t.bytes.to_string(), format!("{:.4}", p.seconds)]);
            rows.push(row);
        }
        let (mut totals, mut notes) = (Vec::new(), Vec::new());
        for (group, total) in self.totals() {
            let name = group.name();
            let mut row = vec![format!("= {name}")];
            row.resize(columns.len(), String::new());
            let first = usize::from(!starred) + 2;
            let counts = [total.work, total.exact_tests, total.depth].map(maybe);
            row[first..first + counts.len()].clone_from_slice(&counts);
            totals.push(row);
            notes.push(format!(
                "{name}: depth {} with scans at log2 m; Brent's bound {} steps on n processors",
                shown(&maybe(total.depth_log_scan)),
                shown(&maybe(total.brent))
            ));
        }
        Table {
            title: "Phases",
            heading: "Phases: modelled | measured (* not the paper's)",
            columns,
            rows,
            totals,
            notes,
        }
    }

    fn round_table(&self) -> Table {
        use TableColumn::{Label, Modelled};
        let counts = RoundTally::COUNTS.map(|count| Modelled(count.name));
        let columns = [Label("round"), Label("phase")].into_iter().chain(counts).collect();
        let row = |RoundRow { key, tally }: &RoundRow| {
            let labels = [key.round.to_string(), key.phase.name().to_owned()];
            labels.into_iter().chain(tally.values().map(|count| count.to_string())).collect()
        };
        let rows = self.rounds.iter().map(row).collect();
        Table {
            title: "Rounds",
            heading: "Rounds (modelled)",
            columns,
            rows,
            totals: Vec::new(),
            notes: Vec::new(),
        }
    }

    fn level_table(&self) -> Table {
        use TableColumn::{Label, Modelled};
        let counts = ["nodes", "leaves", "points", "largest", "split", "attempts", "on separators"];
        let depths = ["partition depth", "neighbours depth", "merge depth"];
        let columns = std::iter::once(Label("level")).chain(counts.into_iter().chain(depths).map(Modelled));
        let row = |l: &LevelRow<LevelDepths>| {
            vec![
                l.level.to_string(),
                l.nodes.to_string(),
                l.leaves.to_string(),
                l.points.to_string(),
                l.largest.to_string(),
                ratio(l.largest_split_ratio),
                l.largest_attempts.to_string(),
                maybe(l.separator_points),
                maybe(l.detail.partition_depth),
                maybe(l.detail.neighbours_depth),
                maybe(l.detail.merge_depth),
            ]
        };
        let t = &self.tree.tree;
        let note = format!(
            "{} levels, {} leaves, {} spheres, {} planes, {} cuts of a curve; split at most {}, on average {}; \
             separator points at most {} m^(1-1/d)",
            t.levels,
            t.leaves,
            t.spheres,
            t.planes,
            t.curves,
            shown(&ratio(t.largest_split_ratio)),
            shown(&ratio(t.mean_split_ratio)),
            shown(&ratio(t.largest_separator_ratio))
        );
        Table {
            title: "Tree levels",
            heading: "Tree levels (modelled)",
            columns: columns.collect(),
            rows: self.tree.by_level.iter().map(row).collect(),
            totals: Vec::new(),
            notes: vec![note],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        Table {
            title: "T",
            heading: "T (modelled | measured)",
            columns: vec![
                TableColumn::Label("name"),
                TableColumn::Modelled("depth"),
                TableColumn::Measured("seconds"),
            ],
            rows: vec![
                vec!["a,b".to_string(), String::new(), "0.5".to_string()],
                vec!["c".to_string(), 12.to_string(), "1.25".to_string()],
            ],
            totals: vec![vec!["= all".to_string(), 12.to_string(), String::new()]],
            notes: vec!["that is all".to_owned()],
        }
    }

    fn rendered(format: TableFormat) -> String {
        let mut out = String::new();
        table().render(format, &mut out);
        out
    }

    #[test]
    fn the_three_formats() {
        let text = "\nT (modelled | measured)\nname   depth  |  seconds\na,b        -  |      0.5\n\
                    c         12  |     1.25\n= all     12  |\nthat is all\n";
        assert_eq!(rendered(TableFormat::Text), text);
        let csv = "name,modelled_depth,measured_seconds\n\"a,b\",,0.5\nc,12,1.25\n";
        assert_eq!(rendered(TableFormat::Csv), csv);
        let markdown = "## T\n\n| name | modelled depth | measured seconds |\n| --- | ---: | ---: |\n\
                        | a,b | - | 0.5 |\n| c | 12 | 1.25 |\n| = all | 12 |  |\n\nthat is all\n\n";
        assert_eq!(rendered(TableFormat::Markdown), markdown);
    }
}
