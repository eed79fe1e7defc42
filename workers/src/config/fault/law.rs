//! The laws of additional steps in faults of charges.

/// The law of a phase's additional steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    /// The logarithm to base 2.
    Log,
    /// The square of the logarithm to base 2.
    LogSquared,
    /// The cube root.
    CubeRoot,
}

impl Law {
    /// All laws.
    pub const ALL: [Law; 3] = [Law::Log, Law::LogSquared, Law::CubeRoot];

    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Law::Log => "log",
            Law::LogSquared => "log2",
            Law::CubeRoot => "root3",
        }
    }

    /// Returns the value of the law for this number of points.
    pub fn value(self, points: u64) -> f64 {
        let points = points.max(1) as f64;
        match self {
            Law::Log => points.log2(),
            Law::LogSquared => points.log2() * points.log2(),
            Law::CubeRoot => points.cbrt(),
        }
    }
}
