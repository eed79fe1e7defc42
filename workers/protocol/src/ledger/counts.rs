//! Tables of counts: structs whose counts are added or compared when parts of the ledger are merged.

use serde::{Serialize, Serializer};

/// How the count of two parts follows from their counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Join {
    /// The sum.
    Sum,
    /// The larger count.
    Max,
}

impl Join {
    /// Returns the count of both.
    pub fn of(self, a: u64, b: u64) -> u64 {
        match self {
            Join::Sum => a + b,
            Join::Max => a.max(b),
        }
    }
}

/// A row of a table of counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Count {
    /// The name, in words joined by hyphens. The field has underscores.
    pub name: &'static str,
    /// How two parts are merged.
    pub join: Join,
}

impl Serialize for Count {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name)
    }
}

/// Writes a struct of counts from its rows: documentation, field, name, [`Join`]. Reports, lines of sweeps, the wire and fits
/// take the counts from the struct, so a new count is one row.
macro_rules! counts {
    ($(#[$meta:meta])* $table:ident: $($(#[doc = $doc:literal])+ $count:ident $name:literal $join:ident;)+) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        #[serde(default)]
        pub struct $table {
            $($(#[doc = $doc])+ pub $count: u64,)+
        }

        impl $table {
            /// The counts, in order.
            pub const COUNTS: [$crate::ledger::Count; [$($name),+].len()] =
                [$($crate::ledger::Count { name: $name, join: $crate::ledger::Join::$join }),+];

            /// Returns the values, in the order of [`Self::COUNTS`].
            pub fn values(&self) -> [u64; Self::COUNTS.len()] {
                [$(self.$count),+]
            }

            /// Returns the counts with these values.
            pub fn from_values(values: [u64; Self::COUNTS.len()]) -> Self {
                let [$($count),+] = values;
                $table { $($count),+ }
            }

            /// Returns the value of a count, or `None` if the table has no count with this name.
            pub fn get(&self, name: &str) -> Option<u64> {
                let at = Self::COUNTS.iter().position(|count| count.name == name)?;
                Some(self.values()[at])
            }

            /// Merges the counts of another part.
            pub fn add(&mut self, other: &Self) {
                $(self.$count = $crate::ledger::Join::$join.of(self.$count, other.$count);)+
            }
        }
    };
}

pub(super) use counts;
