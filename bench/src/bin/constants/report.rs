//! The tables of the rows, and the figures that decide the default.

use std::fmt::Write;

use super::journal::Journal;
use super::setting::{Method, Setting, grid};

/// Returns the table of all settings for each size but the largest, the table of the `few` settings that ran at every
/// size, and the deciding figures.
pub fn markdown(journal: &Journal, default: Setting, few: &[Setting], sizes: &[u64]) -> String {
    let mut text = String::new();
    for &n in &sizes[..sizes.len() - 1] {
        text += &whole_grid(journal, n);
    }
    text += &growth(journal, few, sizes);
    text + &figures(journal, default, sizes)
}

/// Returns a table with a row for each number of samples and great circles, and a column for each leaf size.
fn whole_grid(journal: &Journal, n: u64) -> String {
    let all = grid();
    let mut leaves: Vec<u64> = all.iter().map(|s| s.leaf).collect();
    leaves.sort_unstable();
    leaves.dedup();
    let heads: Vec<String> = leaves.iter().map(|leaf| format!(" leaf {leaf} |")).collect();
    let heads = heads.concat();
    let mut text =
        format!("n = {n}: work per point / T_n\n\n| cut | samples | tries |{heads}\n|---|---|---|");
    text += &"---|".repeat(leaves.len());
    text.push('\n');
    let mut rows: Vec<Setting> = all.iter().map(|s| Setting { leaf: 0, ..*s }).collect();
    rows.sort_unstable();
    rows.dedup();
    for row in rows {
        // Writing to a string does not fail.
        let _ = write!(text, "| {} | {} | {} |", row.method.name(), row.samples, shown(row.tries.into()));
        for &leaf in &leaves {
            let means = journal.means(Setting { leaf, ..row }, n);
            let shown = means.map_or("-".to_owned(), |m| format!("{:.0} / {:.0}", m.work, m.steps));
            let _ = write!(text, " {shown} |");
        }
        text.push('\n');
    }
    text.push('\n');
    text
}

/// Returns a row for each setting and size.
fn growth(journal: &Journal, few: &[Setting], sizes: &[u64]) -> String {
    let mut text =
        "| cut | samples | tries | leaf | n | work per point | of it repair | depth | T_n |\n".to_owned();
    text += &"|---".repeat(9);
    text += "|\n";
    let mut seen: Vec<Setting> = Vec::new();
    for &setting in few {
        if seen.contains(&setting) {
            continue;
        }
        seen.push(setting);
        for &n in sizes {
            let Some(m) = journal.means(setting, n) else { continue };
            let Setting { method, samples, tries, leaf } = setting;
            let [samples, tries, leaf] = [samples, tries.into(), leaf].map(shown);
            // Writing to a string does not fail.
            let _ = writeln!(
                text,
                "| {} | {samples} | {tries} | {leaf} | {n} | {:.0} | {:.0} | {:.0} | {:.0} |",
                method.name(),
                m.work,
                m.repair_work,
                m.depth,
                m.steps
            );
        }
    }
    text.push('\n');
    text
}

/// Returns the ratios that decide the default and the comparisons.
fn figures(journal: &Journal, default: Setting, sizes: &[u64]) -> String {
    let steps = |setting, n| journal.means(setting, n).map(|m| m.steps);
    let mut text = String::new();
    let mut ratio = |what: String, of: Option<f64>, to: Option<f64>| {
        if let Some((of, to)) = of.zip(to) {
            let _ = writeln!(text, "- {what}: {:.3}", of / to);
        }
    };
    for &n in sizes {
        for method in [Method::Spheres, Method::Planes] {
            if let Some(&best) = journal.best(method, n, 1).first() {
                let what =
                    format!("T_n of the default over the best with {} ({best}), n = {n}", method.name());
                ratio(what, steps(default, n), steps(best, n));
            }
        }
        for (other, name) in [(default.by_planes(), "planes"), (Setting::insertion(), "insertion")] {
            ratio(format!("T_n of the default over {name}, n = {n}"), steps(default, n), steps(other, n));
            let work = |setting| journal.means(setting, n).map(|m| m.work);
            ratio(format!("work of the default over {name}, n = {n}"), work(default), work(other));
        }
    }
    if let [first, .., last] = sizes {
        let work = |n: &u64| journal.means(default, *n).map(|m| m.work);
        ratio(format!("work per point of the default, n = {last} over n = {first}"), work(last), work(first));
    }
    text
}

fn shown(number: u64) -> String {
    if number == 0 { "-".to_owned() } else { number.to_string() }
}
