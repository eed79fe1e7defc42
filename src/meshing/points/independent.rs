//! A maximal independent set by rounds of local priorities.
//!
//! **Statement.** In a round every undecided vertex whose priority is smaller than that of all its undecided
//! neighbours joins, and its neighbours are out. Priorities differ, so the smallest undecided one joins: it ends,
//! with an independent set, and every vertex that is out has a neighbour in it. *The set is that of the greedy
//! algorithm in the order of priorities*: by induction over that order, a vertex joins iff none of its neighbours of
//! smaller priority does. So it does not depend on the rounds, only their number does.
//!
//! **Source.** Luby (1986); with fixed random priorities `O(log n)` rounds are expected to suffice (Fischer and Noever
//! 2018). **Work and depth.** The edges of the undecided vertices in each round; one step a round.

/// A maximal independent set.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Independent {
    /// Its members, ascending.
    pub members: Vec<u32>,
    /// How many vertices were undecided at the start of each round.
    pub undecided: Vec<u64>,
}

impl Independent {
    /// The number of rounds.
    pub fn rounds(&self) -> usize {
        self.undecided.len()
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum State {
    Undecided,
    In,
    Out,
}

/// Takes a maximal independent set of the vertices that are not `barred`. `graph` holds the neighbours of each vertex;
/// priorities are all different.
pub fn by_rounds<K: Ord>(graph: &[Vec<u32>], priorities: &[K], barred: &[bool]) -> Independent {
    let mut state: Vec<State> =
        barred.iter().map(|&b| if b { State::Out } else { State::Undecided }).collect();
    let mut open: Vec<u32> =
        (0..graph.len() as u32).filter(|&v| state[v as usize] == State::Undecided).collect();
    let mut undecided = Vec::new();
    while !open.is_empty() {
        undecided.push(open.len() as u64);
        let first = |v: u32| {
            let neighbours = graph[v as usize].iter().filter(|&&u| state[u as usize] == State::Undecided);
            neighbours.into_iter().all(|&u| priorities[v as usize] < priorities[u as usize])
        };
        let joining: Vec<u32> = open.iter().copied().filter(|&v| first(v)).collect();
        for v in joining {
            state[v as usize] = State::In;
            for &u in &graph[v as usize] {
                state[u as usize] = State::Out;
            }
        }
        open.retain(|&v| state[v as usize] == State::Undecided);
    }
    let members = (0..graph.len() as u32).filter(|&v| state[v as usize] == State::In).collect();
    Independent { members, undecided }
}

/// The same set by the greedy algorithm: the reference.
pub fn greedy<K: Ord>(graph: &[Vec<u32>], priorities: &[K], barred: &[bool]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..graph.len() as u32).filter(|&v| !barred[v as usize]).collect();
    order.sort_by(|&u, &v| priorities[u as usize].cmp(&priorities[v as usize]));
    let mut taken = vec![false; graph.len()];
    for v in order {
        taken[v as usize] = graph[v as usize].iter().all(|&u| !taken[u as usize]);
    }
    (0..graph.len() as u32).filter(|&v| taken[v as usize]).collect()
}
