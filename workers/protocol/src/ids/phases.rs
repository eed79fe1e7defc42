//! The phases of a run: one table gives their order, names, groups and directions.
//!
//! A new phase is a row of the table. Its group and its direction decide how the ledger folds it, to which total it belongs, and
//! how reports, traces and predictions present it.

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Writes [`Phase`] and its functions from the rows: documentation, variant, name, [`Group`], [`Flow`].
macro_rules! phases {
    ($($(#[doc = $doc:literal])+ $phase:ident $name:literal $group:ident $flow:ident;)+) => {
        /// The phases of a run, in order. Messages and records contain the number of a phase, reports its name.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[serde(into = "u8", try_from = "u8")]
        #[repr(u8)]
        pub enum Phase {
            $($(#[doc = $doc])+ $phase,)+
        }

        impl Phase {
            /// All phases, in order.
            pub const ALL: [Phase; [$(Phase::$phase),+].len()] = [$(Phase::$phase),+];

            /// Returns the name in reports and traces.
            pub fn name(self) -> &'static str {
                match self {
                    $(Phase::$phase => $name,)+
                }
            }

            /// Returns the group, which decides the total to which the work of the phase belongs.
            pub fn group(self) -> Group {
                match self {
                    $(Phase::$phase => Group::$group,)+
                }
            }

            /// Returns the direction over the tree.
            pub fn flow(self) -> Flow {
                match self {
                    $(Phase::$phase => Flow::$flow,)+
                }
            }
        }
    };
}

phases! {
    /// Each rank reads its block of the points.
    Load "load" Machine Local;
    /// Section 5: trees of cells, level by level: for the local feature size, and for candidates (meshes only).
    Octree "octree" Paper Steps;
    /// Section 5: the size function: its cones, and its evaluations (meshes only).
    Sizes "sizes" Paper Steps;
    /// Section 5: candidates in the cells (meshes only).
    Candidates "candidates" Paper Steps;
    /// Section 5: conflicts of candidates with earlier points (meshes only).
    Conflicts "conflicts" Paper Steps;
    /// Section 5: simplices that are too large, and their circumcentres (meshes only).
    Completion "completion" Paper Steps;
    /// Section 2, and step 2 of Section 4.3: sphere separators, level by level.
    Partition "partition" Paper Down;
    /// Exchange of ghosts near separators (`triangulate` only).
    Halo "halo" Direct Local;
    /// Triangulation of every subdomain with its ghosts (`triangulate` only).
    Pieces "pieces" Direct Local;
    /// Exchange of the ghosts beyond the ghost layers (`triangulate` only).
    Seam "seam" Direct Local;
    /// Choice of the supergraph from a sample of stars.
    Choice "choice" Selection Down;
    /// Section 4.3: radii within every leaf.
    Radii "radii" Paper Local;
    /// Probe of large balls that would otherwise visit many leaves (the punt).
    Probe "probe" Paper Down;
    /// Section 4.3: nearest-neighbour balls, by descent. The bottom-up correction goes up the tree.
    Neighbours "neighbours" Paper Down;
    /// Largest radius and smallest point of every subproblem, up and down the tree.
    Summaries "summaries" Paper Up;
    /// Section 4.5: k-nearest lists within every leaf.
    KnnRadii "knn-radii" Paper Local;
    /// Probe of the k-nearest balls.
    KnnProbe "knn-probe" Paper Down;
    /// Section 4.5: k-nearest neighbours, by descent.
    Knn "knn" Paper Down;
    /// Section 4.3: separator sets. Lists are united on the way up, and each node pays for both ways at once.
    Sets "separator-sets" Paper Down;
    /// Section 4.3, steps 1 to 5, if every set draws its own separator. The sets of a level step together, because they are
    /// no nodes of the partition tree.
    OwnSets "own-sets" Paper Steps;
    /// Section 4.2: the supergraph, leaf by leaf, and its union. A leaf may receive the ends of edges from any other
    /// leaf, so the phase waits for everything before it.
    Graph "graph" Paper Down;
    /// Section 5: a maximal independent set of the graph (`independent` only).
    Independent "independent" Paper Steps;
    /// Section 4.1: local hulls.
    Hulls "hulls" Paper Local;
    /// Check of the stars: fingerprints, and lists where fingerprints differ.
    Check "check" Repair Up;
    /// Star splaying: exchange between stars that disagree.
    Repair "repair" Repair Steps;
    /// Cells that some star lacks ask the leaf of their circumcentre for a point in their circumsphere.
    ProbeCells "probe-cells" Repair Steps;
    /// The certificate of the final stars.
    Certificate "certificate" Repair Up;
    /// Gathering of regions that splaying leaves unresolved.
    Fallback "fallback" Repair Up;
    /// Reduction of the results up the tree.
    Merge "merge" Paper Up;
    /// Each rank builds its share of the result.
    Collect "collect" Machine Local;
    /// The end of the run.
    Done "done" Machine Local;
}

impl Phase {
    /// The phases of Section 5 in which the ranks evaluate a rule. Only meshes have them.
    pub const OF_MESHES: [Phase; 5] =
        [Phase::Octree, Phase::Sizes, Phase::Candidates, Phase::Conflicts, Phase::Completion];

    /// Returns the phase with this number, or `None`.
    pub fn from_number(n: u8) -> Option<Phase> {
        Phase::ALL.get(usize::from(n)).copied()
    }

    /// Returns the phase with this name, or `None`.
    pub fn from_name(name: &str) -> Option<Phase> {
        Phase::ALL.into_iter().find(|phase| phase.name() == name)
    }
}

impl From<Phase> for u8 {
    fn from(phase: Phase) -> u8 {
        phase as u8
    }
}

/// A number that is not the number of a phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("no phase has the number {0}")]
pub struct PhaseNumberError(u8);

impl TryFrom<u8> for Phase {
    type Error = PhaseNumberError;

    fn try_from(number: u8) -> Result<Self, PhaseNumberError> {
        Phase::from_number(number).ok_or(PhaseNumberError(number))
    }
}

/// A phase as its name, for reports.
pub mod names {
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serializer};

    use super::Phase;

    /// Writes the name.
    ///
    /// # Errors
    /// Fails if the serializer fails.
    pub fn serialize<S: Serializer>(phase: &Phase, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(phase.name())
    }

    /// Reads the name.
    ///
    /// # Errors
    /// Fails if no phase has the name.
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Phase, D::Error> {
        let name = String::deserialize(deserializer)?;
        Phase::from_name(&name).ok_or_else(|| D::Error::custom(format!("no phase has the name `{name}`")))
    }
}

/// The direction of a phase over the tree. A descent whose replies return is charged on the way down, so it goes down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// A node starts after its parent. The first node starts when all earlier phases have ended.
    Down,
    /// A node starts after its children.
    Up,
    /// A node starts when its previous phase has ended.
    Local,
    /// All nodes step together.
    Steps,
}

/// A group of phases. Each phase belongs to exactly one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Group {
    /// The algorithm of the paper.
    Paper,
    /// Agreement of the stars, and repair.
    Repair,
    /// Choice of the supergraph.
    Selection,
    /// Direct triangulation of subdomains. Counts no work.
    Direct,
    /// Duties of the machine itself: loading and collecting. Counts no work.
    Machine,
}

impl Group {
    /// Returns the name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Group::Paper => "paper",
            Group::Repair => "repair",
            Group::Selection => "selection",
            Group::Direct => "direct",
            Group::Machine => "machine",
        }
    }

    /// Returns `true` if the phases of the group count work, so that it has a total ([`ByGroup`]).
    pub fn counts_work(self) -> bool {
        ByGroup::<()>::default().get(self).is_some()
    }

    /// Returns the phases of the group, in order.
    pub fn phases(self) -> impl Iterator<Item = Phase> {
        Phase::ALL.into_iter().filter(move |phase| phase.group() == self)
    }
}

/// A value for each group whose phases count work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ByGroup<T> {
    /// The phases of the paper.
    pub paper: T,
    /// The phases of agreement and repair.
    pub repair: T,
    /// The choice of the supergraph.
    pub selection: T,
}

impl<T> ByGroup<T> {
    /// Returns a value for each group.
    pub fn of(mut value: impl FnMut(Group) -> T) -> Self {
        ByGroup {
            paper: value(Group::Paper),
            repair: value(Group::Repair),
            selection: value(Group::Selection),
        }
    }

    /// Returns the groups with their values.
    pub fn each(&self) -> [(Group, &T); 3] {
        let ByGroup { paper, repair, selection } = self;
        [(Group::Paper, paper), (Group::Repair, repair), (Group::Selection, selection)]
    }

    /// Returns the value of a group, or `None` if the group counts no work.
    pub fn get(&self, group: Group) -> Option<&T> {
        match group {
            Group::Paper => Some(&self.paper),
            Group::Repair => Some(&self.repair),
            Group::Selection => Some(&self.selection),
            Group::Direct | Group::Machine => None,
        }
    }

    /// Converts every value.
    pub fn map<U>(self, mut convert: impl FnMut(T) -> U) -> ByGroup<U> {
        let ByGroup { paper, repair, selection } = self;
        ByGroup { paper: convert(paper), repair: convert(repair), selection: convert(selection) }
    }

    /// Pairs the values of both by their groups.
    pub fn zip<U>(self, other: ByGroup<U>) -> ByGroup<(T, U)> {
        ByGroup {
            paper: (self.paper, other.paper),
            repair: (self.repair, other.repair),
            selection: (self.selection, other.selection),
        }
    }

    /// Returns references to the values.
    pub fn as_ref(&self) -> ByGroup<&T> {
        ByGroup { paper: &self.paper, repair: &self.repair, selection: &self.selection }
    }
}

impl<T> ByGroup<Option<T>> {
    /// Returns the values if every group has one.
    pub fn all(self) -> Option<ByGroup<T>> {
        let ByGroup { paper, repair, selection } = self;
        Some(ByGroup { paper: paper?, repair: repair?, selection: selection? })
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn phase_numbers_and_names_round_trip() {
        for (i, phase) in Phase::ALL.into_iter().enumerate() {
            assert_eq!(phase as usize, i);
            assert_eq!(Phase::from_number(i as u8), Some(phase));
            assert_eq!(Phase::from_name(phase.name()), Some(phase));
        }
        assert_eq!(Phase::from_number(99), None);
        assert_eq!(Phase::from_name("lunch"), None);
        assert_eq!(Phase::try_from(99), Err(PhaseNumberError(99)));
    }

    #[test]
    fn groups_share_the_phases() {
        let groups = [Group::Paper, Group::Repair, Group::Selection, Group::Direct, Group::Machine];
        let all: Vec<Phase> = groups.into_iter().flat_map(Group::phases).collect();
        assert_eq!(all.len(), Phase::ALL.len());
        assert_eq!(all.into_iter().collect::<BTreeSet<_>>().len(), Phase::ALL.len());
        let sums = ByGroup::of(|group| group.phases().count());
        assert!(sums.each().into_iter().all(|(group, count)| sums.get(group) == Some(count) && *count > 0));
        assert_eq!((sums.get(Group::Direct), sums.get(Group::Machine)), (None, None));
        assert_eq!(sums.selection, 1);
    }
}
