//! What a run is: one [`Spec`] of groups, the tasks, and the checks that need no points.

#[macro_use]
mod value;

mod constants;
mod control;
mod error;
mod graph;
mod groups;
mod machine;
mod options;
mod periodic;
mod row;
mod task;

pub(crate) use constants::TreeConstants;
pub use constants::{Constants, Purpose};
pub use control::{Control, Keep, MOST_POINTS, Nodes, Planted, Progress, ProgressFn};
pub use error::SpecError;
pub use graph::{Alpha, DEFAULT_ALPHA, Graph, GraphKind, alpha_of_spacing};
pub use groups::{InputRules, MOST_WORKERS, Recursion, Spec, Tree};
pub use machine::{DEFAULT_SEED, Machine, Registers, Transport, TransportName, Workers, cores};
pub use options::{OPTIONS, options_of, row, series_name};
pub use periodic::Periodic;
pub(crate) use row::option;
pub use row::{Commands, Heading, Matters, Row, Series};
pub use septet_workers::config::Neighbours;
pub use septet_workers::config::{
    Correction, FAULTS, Factor as FaultFactor, Fault, FaultForm, FaultTextError, Law as FaultLaw, Partition,
    Repair, SetRule as SeparatorSets,
};
pub use task::{Task, Until};
pub use value::{Setting, Value, Word, Words, bytes, count};

words!(SeparatorSets {
    Both "both" "Both sides receive them, and the separators are those of the partition",
    Own "own" "Both sides receive them, and every set draws its own separator, as printed in the paper",
    Smaller "smaller" "Only the side with fewer of them sends them to the other",
    Ghost "ghost" "Both sides receive them as ghosts",
});
words!(Partition {
    Sphere "sphere" "Sphere separators, as in the paper",
    Kd "kd" "K-d planes, as a baseline",
    Hilbert "hilbert" "Blocks along a Hilbert curve, as a baseline",
});
words!(Correction {
    Descent "descent" "One descent from the root",
    BottomUp "naive" "Bottom-up, node by node, as a baseline",
    Stages "fmt" "Bottom-up in stages, after Frieze, Miller and Teng",
    Pairs "pairs" "Well-separated pairs, after Callahan and Kosaraju",
});
words!(Repair {
    Probe "probe" "Cells that a star lacks are told to it, and ask one leaf for a point in their circumsphere",
    Splay "splay" "Cells that a star lacks are told to it: star splaying, as a baseline",
});
