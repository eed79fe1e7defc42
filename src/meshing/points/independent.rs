//! A maximal independent set by rounds of local priorities.
//!
//! **Statement.** In each round, an undecided vertex joins the set if its priority is smaller than the priorities of
//! all its undecided neighbours. Its neighbours are excluded. Priorities are distinct, so the smallest undecided
//! vertex joins and the algorithm terminates. The result is an independent set, and every excluded vertex has a
//! neighbour in it. *The greedy algorithm in the order of priorities gives the same set.* By induction over that
//! order, a vertex joins iff no neighbour of smaller priority joins. Only the number of rounds therefore depends on
//! the schedule.
//!
//! **Source.** Luby (1986). With fixed random priorities, the expected number of rounds is `O(log n)` (Fischer and
//! Noever 2018). **Work and depth.** Each round costs one step, and work for each edge of an undecided vertex.

/// A maximal independent set.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Independent {
    /// The members, in ascending order.
    pub members: Vec<u32>,
    /// The number of undecided vertices at the start of each round.
    pub undecided: Vec<u64>,
}

impl Independent {
    /// Returns the number of rounds.
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

/// Returns a maximal independent set of the vertices that are not `barred`. `graph` lists the neighbours of each
/// vertex. Priorities must be distinct.
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

/// Computes the set of [`by_rounds`] with the greedy algorithm, as a reference.
pub fn greedy<K: Ord>(graph: &[Vec<u32>], priorities: &[K], barred: &[bool]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..graph.len() as u32).filter(|&v| !barred[v as usize]).collect();
    order.sort_by(|&u, &v| priorities[u as usize].cmp(&priorities[v as usize]));
    let mut taken = vec![false; graph.len()];
    for v in order {
        taken[v as usize] = graph[v as usize].iter().all(|&u| !taken[u as usize]);
    }
    (0..graph.len() as u32).filter(|&v| taken[v as usize]).collect()
}
