//! The cells that a segment crosses, and the triangles that replace them.

use septet_geometry::predicates::Sign;

use super::chain::{Beyond, Cavity, Chain};
use super::constrained::{Constrained, Crossed, NONE, TAKEN};
use super::star::{next, previous};

impl Chain {
    /// Appends the edge opposite a corner of a crossed cell.
    fn push(&mut self, of: &Constrained, vertex: u32, old: (u32, usize)) {
        let cell = of.across[old.0 as usize][old.1];
        let corner = if cell == NONE { 0 } else { of.corner_towards(cell, old.0) };
        let is_constrained = of.is_constrained(old.0, old.1);
        let number = self.edges.len() as u32;
        let mut twin = None;
        if cell != NONE && of.marks[cell as usize] & TAKEN != 0 {
            twin = self.edges.iter().rposition(|e| e.old == (cell, corner)).map(|i| i as u32);
            if let Some(i) = twin {
                self.edges[i as usize].twin = Some(number);
            }
        }
        self.edges.push(Beyond { old, cell, corner, is_constrained, twin });
        self.vertices.push(vertex);
    }
}

impl Cavity {
    /// Collects the cells that the segment crosses, from a corner of the first one to the first vertex on the segment,
    /// which is returned.
    pub(super) fn march(
        &mut self,
        of: &mut Constrained,
        segment: [u32; 2],
        (mut cell, mut corner): (u32, usize),
    ) -> Result<u32, Crossed> {
        self.taken.clear();
        self.left.start(segment[0]);
        self.right.start(segment[0]);
        let [mut right, mut left] = [next(corner), previous(corner)].map(|i| of.cells[cell as usize][i]);
        self.take(of, cell);
        self.left.push(of, left, (cell, next(corner)));
        self.right.push(of, right, (cell, previous(corner)));
        let end = loop {
            let beyond = of.across[cell as usize][corner];
            if of.is_constrained(cell, corner) || beyond == NONE {
                break Err(Crossed([left, right]));
            }
            corner = of.corner_towards(beyond, cell);
            cell = beyond;
            self.take(of, cell);
            let apex = of.cells[cell as usize][corner];
            let (past_left, past_right) = ((cell, previous(corner)), (cell, next(corner)));
            let side = if apex == segment[1] { Sign::Zero } else { of.side(segment, apex) };
            match side {
                Sign::Zero => {
                    self.left.push(of, apex, past_left);
                    self.right.push(of, apex, past_right);
                    break Ok(apex);
                }
                Sign::Positive => {
                    self.left.push(of, apex, past_left);
                    left = apex;
                    corner = next(corner);
                }
                Sign::Negative => {
                    self.right.push(of, apex, past_right);
                    right = apex;
                    corner = previous(corner);
                }
            }
        };
        for &cell in &self.taken {
            of.marks[cell as usize] &= !TAKEN;
        }
        end
    }

    fn take(&mut self, of: &mut Constrained, cell: u32) {
        of.marks[cell as usize] |= TAKEN;
        self.taken.push(cell);
    }

    /// Replaces the crossed cells by the triangles of the two polygons.
    pub(super) fn fill(&mut self, of: &mut Constrained) {
        self.right.reverse();
        let Cavity { left, right, taken, parts, inner } = self;
        let above = fill_chain(of, left, taken, parts, inner);
        let below = fill_chain(of, right, taken, parts, inner);
        of.across[above as usize][2] = below;
        of.across[below as usize][2] = above;
        of.marks[above as usize] |= 4;
        of.marks[below as usize] |= 4;
    }
}

/// Fills the polygon between a chain and the edge from its first to its last vertex, on whose left it lies. Returns the
/// triangle at this edge, which is opposite corner 2.
fn fill_chain(
    of: &mut Constrained,
    chain: &Chain,
    free: &mut Vec<u32>,
    parts: &mut Vec<(usize, usize, u32, usize)>,
    inner: &mut Vec<(u32, usize)>,
) -> u32 {
    inner.clear();
    inner.resize(chain.edges.len(), (NONE, 0));
    let mut top = NONE;
    parts.push((0, chain.vertices.len() - 1, NONE, 0));
    while let Some((low, high, base, corner)) = parts.pop() {
        if high == low + 1 {
            attach(of, &chain.edges, inner, low, (base, corner));
            continue;
        }
        let [a, b] = [low, high].map(|i| chain.vertices[i]);
        let mut at = low + 1;
        for i in low + 2..high {
            let (c, v) = (chain.vertices[at], chain.vertices[i]);
            if v != c && of.conflicts([a, b, c], v) {
                at = i;
            }
        }
        // A chain of n inner vertices has n triangles, and together the chains have as many as were crossed.
        let cell = free.pop().unwrap_or(NONE);
        let c = chain.vertices[at];
        of.cells[cell as usize] = [a, b, c];
        of.across[cell as usize] = [NONE, NONE, base];
        of.marks[cell as usize] = 0;
        for v in [a, b, c] {
            of.at[v as usize] = cell;
        }
        if base == NONE {
            top = cell;
        } else {
            of.across[base as usize][corner] = cell;
        }
        parts.push((low, at, cell, 1));
        parts.push((at, high, cell, 0));
    }
    top
}

/// Joins a corner of a new cell with the neighbour beyond an edge of the chain.
fn attach(
    of: &mut Constrained,
    edges: &[Beyond],
    inner: &mut [(u32, usize)],
    number: usize,
    (cell, corner): (u32, usize),
) {
    let edge = edges[number];
    let bit = u8::from(edge.is_constrained);
    of.marks[cell as usize] |= bit << corner;
    if let Some(twin) = edge.twin {
        inner[number] = (cell, corner);
        let (other, there) = inner[twin as usize];
        if other != NONE {
            of.across[cell as usize][corner] = other;
            of.across[other as usize][there] = cell;
        }
        return;
    }
    of.across[cell as usize][corner] = edge.cell;
    if edge.cell != NONE {
        of.across[edge.cell as usize][edge.corner] = cell;
    }
}
