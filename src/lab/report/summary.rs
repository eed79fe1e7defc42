//! A summary of the report in a few lines.

use std::fmt::Write;

use septet_core::config::{Correction, Partition};

use super::schema::{Report, SupergraphReport};

/// Formats seconds with their significant digits.
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
    /// Returns the main results in a few lines.
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
        if self.machine.rounds > 0 {
            let (r, m) = (&self.repair, &self.machine);
            if self.supergraph.kind != "none" {
                lines.push(format!("  {}", self.supergraph.line()));
            }
            lines.extend(self.baselines());
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

    /// Describes the baselines that replaced steps of the paper's algorithm.
    fn baselines(&self) -> Option<String> {
        let p = &self.parameters;
        let planes = (p.partition != Partition::Sphere.name()).then_some("partition by k-d planes");
        let bottom_up = (p.neighbours != Correction::Descent.name()).then_some("balls corrected bottom-up");
        let both: Vec<&str> = planes.into_iter().chain(bottom_up).collect();
        (!both.is_empty()).then(|| format!("  baselines: {}", both.join(", ")))
    }

    /// Describes points that span less than the space, in one line.
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
}
