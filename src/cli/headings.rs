//! Headings of the option groups in the help.

/// Options of the input.
pub const INPUT: &str = "Input";

/// Options of the outputs.
pub const OUTPUT: &str = "Output";

/// Options of reports and tables.
pub const REPORTS: &str = "Reports";
