//! SVG drawings: elements as text, with colours by class, so that the theme of the page applies.

use std::fmt::Write;

/// A drawing: its elements, and its size in pixels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    elements: String,
    width: f64,
    height: f64,
}

/// The style of an SVG file. The page defines the same classes and variables.
pub(super) const STYLE: &str = include_str!("assets/figure.css");

/// Escapes text for use in markup.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Formats a coordinate with two decimals.
pub(super) fn short(x: f64) -> String {
    let text = format!("{x:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

impl Drawing {
    pub(super) fn new(width: f64, height: f64) -> Self {
        Drawing { elements: String::new(), width, height }
    }

    pub(super) fn raw(&mut self, element: &str) {
        self.elements.push_str(element);
        self.elements.push('\n');
    }

    /// Adds text at a position; `anchor` is start, middle or end.
    pub(super) fn text(&mut self, class: &str, at: (f64, f64), anchor: &str, text: &str) {
        let (x, y) = (short(at.0), short(at.1));
        let text = escape(text);
        self.raw(&format!(r#"<text class="{class}" x="{x}" y="{y}" text-anchor="{anchor}">{text}</text>"#));
    }

    /// Adds text rotated by 90 degrees counter-clockwise.
    pub(super) fn upright(&mut self, class: &str, at: (f64, f64), anchor: &str, text: &str) {
        let (x, y) = (short(at.0), short(at.1));
        let text = escape(text);
        self.raw(&format!(
            r#"<text class="{class}" transform="translate({x} {y}) rotate(-90)" text-anchor="{anchor}">{text}</text>"#
        ));
    }

    pub(super) fn rect(&mut self, class: &str, at: (f64, f64), size: (f64, f64)) {
        let [x, y, w, h] = [at.0, at.1, size.0.max(0.0), size.1.max(0.0)].map(short);
        self.raw(&format!(r#"<rect class="{class}" x="{x}" y="{y}" width="{w}" height="{h}"/>"#));
    }

    pub(super) fn line(&mut self, class: &str, from: (f64, f64), to: (f64, f64)) {
        let [a, b, c, d] = [from.0, from.1, to.0, to.1].map(short);
        self.raw(&format!(r#"<path class="{class}" d="M{a} {b}L{c} {d}"/>"#));
    }

    pub(super) fn polyline(&mut self, class: &str, points: &[(f64, f64)]) {
        let mut d = String::new();
        for (i, p) in points.iter().enumerate() {
            let _ = write!(d, "{}{} {}", if i == 0 { 'M' } else { 'L' }, short(p.0), short(p.1));
        }
        self.raw(&format!(r#"<path class="{class}" d="{d}"/>"#));
    }

    /// Adds a mark. Its shape, one of four, distinguishes series without colour.
    pub(super) fn mark(&mut self, class: &str, shape: usize, at: (f64, f64), r: f64) {
        let [x, y] = [at.0, at.1].map(short);
        let s = short(r);
        let d = match shape % 4 {
            0 => format!("M{x} {y}m-{s} 0a{s} {s} 0 1 0 {w} 0a{s} {s} 0 1 0 -{w} 0z", w = short(2.0 * r)),
            1 => format!("M{x} {y}m-{s} -{s}h{w}v{w}h-{w}z", w = short(2.0 * r)),
            2 => format!("M{x} {y}m0 -{t}l{t} {t}l-{t} {t}l-{t} -{t}z", t = short(1.35 * r)),
            _ => format!("M{x} {y}m0 -{t}l{t} {u}h-{u}z", t = short(1.3 * r), u = short(2.6 * r)),
        };
        self.raw(&format!(r#"<path class="{class}" d="{d}"/>"#));
    }

    /// Returns the drawing as an element of the page, whose style applies.
    pub(super) fn inline(&self, label: &str) -> String {
        let (w, h) = (short(self.width), short(self.height));
        format!(
            "<svg class=\"figure\" viewBox=\"0 0 {w} {h}\" role=\"img\" aria-label=\"{}\">\n{}</svg>",
            escape(label),
            self.elements
        )
    }

    /// Returns the drawing as an SVG file with its own style.
    pub(super) fn alone(&self, title: &str) -> String {
        let (w, h) = (short(self.width), short(self.height));
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"figure \
             alone\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\">\n<title>{}</title>\n<style>{STYLE}</style>\n\
             <rect class=\"ground\" width=\"100%\" height=\"100%\"/>\n{}</svg>\n",
            escape(title),
            self.elements
        )
    }
}
