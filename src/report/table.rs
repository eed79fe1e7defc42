//! The report for people: a summary, and aligned tables with modelled and measured columns apart.

use std::fmt::Write;

use super::schema::{Report, SupergraphReport};

/// Rows of cells to be aligned.
struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    fn new(head: &[&str]) -> Self {
        Table { rows: vec![head.iter().map(|h| (*h).to_owned()).collect()] }
    }

    fn row(&mut self, cells: Vec<String>) {
        self.rows.push(cells);
    }

    /// The first column to the left, the others to the right.
    fn render(&self, out: &mut String) {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let width = |c: usize| {
            self.rows.iter().filter_map(|r| r.get(c)).map(|s| s.chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..columns).map(width).collect();
        for row in &self.rows {
            let mut line = String::new();
            for (c, cell) in row.iter().enumerate() {
                let pad = " ".repeat(widths[c] - cell.chars().count());
                let (cell, gap) =
                    if c == 0 { (format!("{cell}{pad}"), "") } else { (format!("{pad}{cell}"), "  ") };
                line.push_str(gap);
                line.push_str(&cell);
            }
            out.push_str(line.trim_end());
            out.push('\n');
        }
    }
}

fn maybe(x: Option<u64>) -> String {
    x.map_or_else(|| "-".to_owned(), |x| x.to_string())
}

fn ratio(x: Option<f64>) -> String {
    x.map_or_else(|| "-".to_owned(), |x| format!("{x:.3}"))
}

/// Seconds, with the digits that mean something.
fn seconds(s: f64) -> String {
    if s < 0.1 { format!("{:.1} ms", s * 1e3) } else { format!("{s:.2} s") }
}

impl SupergraphReport {
    fn line(&self) -> String {
        let parameter = match (self.alpha, self.k) {
            (Some(alpha), _) => format!(", alpha {alpha}"),
            (_, Some(k)) => format!(", k {k}"),
            _ => String::new(),
        };
        format!("supergraph {}{parameter} ({})", self.kind, self.why)
    }
}

impl Report {
    /// What a reader wants to know at once, a few lines.
    pub fn summary(&self) -> Vec<String> {
        let cells = if self.space == 2 { "triangles" } else { "tetrahedra" };
        let p = &self.points;
        let mut points = format!("{} points", p.used);
        if p.duplicate > 0 {
            let _ = write!(points, " ({} more coincide with them)", p.duplicate);
        }
        if p.refused > 0 {
            let _ = write!(points, " ({} refused)", p.refused);
        }
        let mut lines = vec![format!(
            "septet: {points}, {} {cells}, {} hull facets; certificate {}",
            self.simplices, self.hull_facets, self.certificate
        )];
        if self.supergraph.kind != "none" {
            let (r, m) = (&self.repair, &self.machine);
            lines.push(format!("  {}", self.supergraph.line()));
            let fallback = self.fallback.as_ref().map_or_else(
                || "no fallback".to_owned(),
                |f| format!("fallback on {} points: {}", f.points, f.reason),
            );
            lines.push(format!("  repair {} rounds, {} stars; {fallback}", r.rounds, r.stars));
            let mut machine = format!(
                "  {} workers, {} rounds, {} messages, {} bytes",
                m.workers, m.rounds, m.messages, m.bytes
            );
            if let (Some(work), Some(depth)) = (m.paper.work, m.paper.depth) {
                let _ = write!(machine, "; work {work}, depth {depth}");
            }
            lines.push(machine);
        }
        let s = &self.seconds;
        let peak = self.peak_rss_bytes.map_or_else(String::new, |b| format!(", peak memory {} MiB", b >> 20));
        lines.push(format!(
            "  read {}, triangulate {}, write {}, in all {}{peak}",
            seconds(s.read),
            seconds(s.triangulate),
            seconds(s.write),
            seconds(s.total)
        ));
        lines
    }

    /// One line on points that span less than the space.
    pub fn flat_note(&self) -> String {
        let span = match self.dimension {
            -1 => "there are no points".to_owned(),
            0 => "all points coincide (dimension 0)".to_owned(),
            1 => "all points lie on a line (dimension 1)".to_owned(),
            _ => "all points lie in a plane (dimension 2)".to_owned(),
        };
        let advice = if self.space == 3 && self.dimension == 2 {
            "; give -d 2 to triangulate x and y alone"
        } else {
            ""
        };
        format!("{span}: no cells{advice}")
    }

    /// All tables of `--profile`.
    pub fn tables(&self) -> String {
        let mut out = String::new();
        self.phase_table(&mut out);
        self.round_table(&mut out);
        self.level_table(&mut out);
        out
    }

    fn phase_table(&self, out: &mut String) {
        out.push_str("\nPhases: modelled | measured (* not the paper's)\n");
        let head = ["phase", "rounds", "work", "depth", "critical", "messages", "bytes", "|", "seconds"];
        let mut table = Table::new(&head);
        for p in &self.phases {
            table.row(vec![
                format!("{}{}", p.name, if p.paper { "" } else { " *" }),
                p.rounds.to_string(),
                maybe(p.work),
                maybe(p.depth),
                maybe(p.critical_depth),
                p.messages.to_string(),
                p.bytes.to_string(),
                "|".to_owned(),
                format!("{:.4}", p.seconds),
            ]);
        }
        let totals = [("paper", &self.machine.paper), ("repair", &self.machine.repair)];
        for (name, total) in totals.iter().filter(|(_, t)| t.work.is_some()) {
            table.row(vec![
                format!("= {name}"),
                String::new(),
                maybe(total.work),
                maybe(total.depth),
                String::new(),
                String::new(),
                String::new(),
                "|".to_owned(),
            ]);
        }
        table.render(out);
        for (name, total) in totals.iter().filter(|(_, t)| t.work.is_some()) {
            let _ = writeln!(
                out,
                "{name}: depth {} with scans at log2 m; Brent's bound {} steps on n processors",
                maybe(total.depth_log_scan),
                maybe(total.brent)
            );
        }
    }

    fn round_table(&self, out: &mut String) {
        out.push_str("\nRounds (modelled)\n");
        let head = [
            "round",
            "phase",
            "active",
            "merged",
            "separators",
            "retries",
            "points",
            "messages",
            "bytes",
            "largest",
        ];
        let mut table = Table::new(&head);
        for r in &self.rounds {
            table.row(vec![
                r.round.to_string(),
                r.phase.to_owned(),
                r.active.to_string(),
                r.merged.to_string(),
                r.separators.to_string(),
                r.retries.to_string(),
                r.points.to_string(),
                r.messages.to_string(),
                r.bytes.to_string(),
                r.largest.to_string(),
            ]);
        }
        table.render(out);
    }

    fn level_table(&self, out: &mut String) {
        out.push_str("\nTree levels (modelled)\n");
        let head = [
            "level",
            "nodes",
            "leaves",
            "points",
            "largest",
            "split",
            "attempts",
            "on separators",
            "partition depth",
            "neighbours depth",
            "merge depth",
        ];
        let mut table = Table::new(&head);
        for l in &self.tree.by_level {
            table.row(vec![
                l.level.to_string(),
                l.nodes.to_string(),
                l.leaves.to_string(),
                l.points.to_string(),
                l.largest.to_string(),
                ratio(l.largest_split_ratio),
                l.largest_attempts.to_string(),
                l.separator_points.to_string(),
                maybe(l.partition_depth),
                maybe(l.neighbours_depth),
                maybe(l.merge_depth),
            ]);
        }
        table.render(out);
        let t = &self.tree;
        let _ = writeln!(
            out,
            "{} levels, {} leaves, {} spheres, {} planes; split at most {}, on average {}; \
             separator points at most {} m^(1-1/d)",
            t.levels,
            t.leaves,
            t.spheres,
            t.planes,
            ratio(t.largest_split_ratio),
            ratio(t.mean_split_ratio),
            ratio(t.largest_separator_ratio)
        );
    }
}
