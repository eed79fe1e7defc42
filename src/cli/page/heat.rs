//! Heat maps of the traffic: by round and sender, and by receiver and sender.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::cells::Cells;
use super::data::{RunData, number, text};
use super::svg::Drawing;
use super::{DataTable, PageFigure, Variant};

const LEFT: f64 = 62.0;
const RIGHT: f64 = 706.0;

/// Names a bin: the coordinator, a worker, or a range of workers.
fn bin_name(bins: &[Value], at: f64) -> String {
    let bin = &bins[(at as usize).min(bins.len().saturating_sub(1))];
    let (first, last) = (number(&bin["first"]), number(&bin["last"]));
    match (first, last) {
        (0.0, _) => "coordinator".to_owned(),
        (a, b) if a == b => format!("{a}"),
        (a, b) => format!("{a}–{b}"),
    }
}

/// Returns at most nine ticks of an axis of bins; `c` is the coordinator.
fn bin_ticks(bins: &[Value]) -> Vec<(usize, String)> {
    let workers = bins.len().saturating_sub(1).max(1);
    let stride = [1, 2, 4, 8, 16, 32, 64, 128].into_iter().find(|s| workers / s <= 9).unwrap_or(128);
    let name = |i: usize| match (i, bins.get(i)) {
        (0, _) | (_, None) => "c".to_owned(),
        (_, Some(bin)) => format!("{}", number(&bin["first"])),
    };
    (0..bins.len()).filter(|i| i % stride == 0).map(|i| (i, name(i))).collect()
}

/// Returns the phases in the order of rounds. Each has a name, a first and a last column.
fn spans(columns: &[(f64, String)]) -> Vec<(String, usize, usize)> {
    let mut spans: Vec<(String, usize, usize)> = Vec::new();
    for (i, (_, phase)) in columns.iter().enumerate() {
        match spans.last_mut() {
            Some(span) if span.0 == *phase => span.2 = i,
            _ => spans.push((phase.clone(), i, i)),
        }
    }
    spans
}

/// Returns the columns before which rounds are omitted.
fn gaps(columns: &[(f64, String)]) -> Vec<usize> {
    let gap = |i: &usize| columns[*i].0 > columns[i - 1].0 + 1.0;
    (1..columns.len()).filter(gap).collect()
}

/// Returns the number of rounds between the first and the last column that have none.
fn omitted(columns: &[(f64, String)]) -> f64 {
    let steps = columns.windows(2).map(|pair| (pair[1].0 - pair[0].0 - 1.0).max(0.0));
    steps.sum()
}

/// Draws the rounds by worker.
pub(super) fn timeline(run: &RunData) -> Option<PageFigure> {
    let rows = run.rows("/timeline/rows");
    let mut columns: Vec<(f64, String)> =
        rows.iter().map(|r| (number(&r["round"]), text(&r["phase"]).to_owned())).collect();
    columns.sort_by(|a, b| a.0.total_cmp(&b.0));
    columns.dedup();
    let variants: Vec<Variant> = [("bytes", "B"), ("messages", "messages"), ("points", "points")]
        .iter()
        .filter_map(|m| rounds(run, rows, &columns, *m))
        .collect();
    let marks = match omitted(&columns) {
        0.0 => String::new(),
        1.0 => " One round without messages is omitted; a stroke on the axis marks the place.".to_owned(),
        n => format!(" {n} rounds without messages are omitted; a stroke on the axis marks each place."),
    };
    let caption = format!(
        "Messages and bytes by worker and round. The labels are the round numbers of the machine.{marks} Row c is the \
         coordinator."
    );
    (!variants.is_empty()).then_some(PageFigure {
        id: "timeline",
        title: "Rounds by worker",
        caption,
        variants,
    })
}

fn rounds(
    run: &RunData,
    rows: &[Value],
    columns: &[(f64, String)],
    (key, unit): (&str, &str),
) -> Option<Variant> {
    let bins = run.rows("/timeline/bins");
    let mut values: BTreeMap<(u32, u32), f64> = BTreeMap::new();
    let mut table = DataTable::new(&["round", "phase", "worker", "messages", "bytes", "points"]);
    for row in rows {
        let (round, phase) = (number(&row["round"]), text(&row["phase"]));
        let column = columns.iter().position(|c| c.0 == round && c.1 == phase)? as u32;
        *values.entry((number(&row["worker"]) as u32, column)).or_default() += number(&row[key]);
        let worker = bin_name(bins, number(&row["worker"]));
        let value = |k: &str| row[k].clone();
        table.rows.push(vec![
            value("round"),
            value("phase"),
            json!(worker),
            value("messages"),
            value("bytes"),
            value("points"),
        ]);
    }
    let cells = Cells::new(values);
    if cells.is_empty() {
        return None;
    }
    let top = 92.0;
    let height = (bins.len() as f64 * 8.0).clamp(120.0, 380.0);
    let size = ((RIGHT - LEFT) / columns.len() as f64, height / bins.len() as f64);
    let mut out = Drawing::new(820.0, top + height + 56.0);
    out.rect("plot", (LEFT, top), (RIGHT - LEFT, height));
    let mut last = f64::NEG_INFINITY;
    for (phase, from, to) in spans(columns) {
        let (x0, x1) = (LEFT + size.0 * from as f64, LEFT + size.0 * (to + 1) as f64);
        out.line("grid", (x0, top - 6.0), (x0, top + height));
        let middle = f64::midpoint(x0, x1) + 4.0;
        if middle - last >= 12.0 {
            let place = (middle, top - 10.0);
            let [x, y] = [place.0, place.1].map(super::svg::short);
            let name = super::svg::escape(&phase);
            out.raw(&format!(
                r#"<text class="tick" transform="translate({x} {y}) rotate(-55)">{name}</text>"#
            ));
            last = middle;
        }
    }
    cells.draw(&mut out, (LEFT, top), size);
    worker_ticks(&mut out, bins, (LEFT, top), size.1);
    let stride = (columns.len() / 12).max(1);
    for (i, (round, _)) in columns.iter().enumerate().step_by(stride) {
        let x = LEFT + size.0 * (i as f64 + 0.5);
        out.text("tick", (x, top + height + 17.0), "middle", &format!("{round}"));
    }
    out.rect("outline", (LEFT, top), (RIGHT - LEFT, height));
    for at in gaps(columns) {
        let x = LEFT + size.0 * at as f64;
        out.line("fit c2", (x - 3.0, top + height + 5.0), (x + 3.0, top + height - 5.0));
    }
    out.text("label", (f64::midpoint(LEFT, RIGHT), top + height + 42.0), "middle", "round");
    out.upright("label", (16.0, top + height / 2.0), "middle", "worker");
    cells.scale(&mut out, (RIGHT + 22.0, top + 4.0), &format!("{key} sent{}", unit_note(key, unit)));
    Some(Variant { name: key.to_owned(), body: out, table })
}

fn unit_note(key: &str, unit: &str) -> String {
    if key == unit { String::new() } else { format!(" [{unit}]") }
}

fn worker_ticks(out: &mut Drawing, bins: &[Value], corner: (f64, f64), step: f64) {
    for (i, name) in bin_ticks(bins) {
        let y = corner.1 + step * (i as f64 + 0.5) + 4.0;
        out.text("tick", (corner.0 - 7.0, y), "end", &name);
    }
}

/// Draws the traffic by sender and receiver, for all phases together and for each phase.
pub(super) fn traffic(run: &RunData) -> Option<PageFigure> {
    let rows = run.rows("/traffic/rows");
    let mut phases: Vec<&str> = Vec::new();
    for row in rows {
        if !phases.contains(&text(&row["phase"])) {
            phases.push(text(&row["phase"]));
        }
    }
    let mut variants = Vec::new();
    for (key, unit) in [("bytes", "B"), ("messages", "messages")] {
        variants.extend(matrix(run, rows, None, key, unit));
        variants.extend(phases.iter().filter_map(|p| matrix(run, rows, Some(p), key, unit)));
    }
    let grouped = run.value.pointer("/traffic/grouped") == Some(&json!(true));
    let bins = if grouped { " Each bin holds contiguous ranks." } else { "" };
    let caption = format!(
        "Row: sender; column: receiver; c is the coordinator. The group of a subproblem is a range of ranks, so the blocks \
         on the diagonal are subtrees.{bins} Messages of a rank to itself are not counted."
    );
    (!variants.is_empty()).then_some(PageFigure {
        id: "traffic",
        title: "Worker to worker",
        caption,
        variants,
    })
}

fn matrix(run: &RunData, rows: &[Value], phase: Option<&str>, key: &str, unit: &str) -> Option<Variant> {
    let bins = run.rows("/traffic/bins");
    let mut values: BTreeMap<(u32, u32), f64> = BTreeMap::new();
    for row in rows.iter().filter(|r| phase.is_none_or(|p| text(&r["phase"]) == p)) {
        let place = (number(&row["from"]) as u32, number(&row["to"]) as u32);
        *values.entry(place).or_default() += number(&row[key]);
    }
    let mut table = DataTable::new(&["from", "to", key]);
    for (&(from, to), &value) in &values {
        let name = |at: u32| json!(bin_name(bins, f64::from(at)));
        table.rows.push(vec![name(from), name(to), json!(value)]);
    }
    let cells = Cells::new(values);
    if cells.is_empty() {
        return None;
    }
    let (left, top, side) = (LEFT + 100.0, 14.0, 440.0);
    let size = side / bins.len() as f64;
    let mut out = Drawing::new(820.0, top + side + 56.0);
    out.rect("plot", (left, top), (side, side));
    cells.draw(&mut out, (left, top), (size, size));
    out.rect("outline", (left, top), (side, side));
    worker_ticks(&mut out, bins, (left, top), size);
    for (i, name) in bin_ticks(bins) {
        let x = left + size * (i as f64 + 0.5);
        out.text("tick", (x, top + side + 17.0), "middle", &name);
    }
    out.text("label", (left + side / 2.0, top + side + 42.0), "middle", "receiver");
    out.upright("label", (left - 46.0, top + side / 2.0), "middle", "sender");
    cells.scale(&mut out, (left + side + 26.0, top + 12.0), &format!("{key}{}", unit_note(key, unit)));
    let name = format!("{key}, {}", phase.unwrap_or("all phases"));
    Some(Variant { name, body: out, table })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn omitted_rounds_are_marked() {
        let columns: Vec<(f64, String)> =
            [1.0, 2.0, 5.0, 5.0, 7.0].map(|round| (round, String::new())).to_vec();
        assert_eq!((gaps(&columns), omitted(&columns)), (vec![2, 4], 3.0));
        assert_eq!((gaps(&[]), omitted(&columns[..1])), (Vec::new(), 0.0));
    }
}
