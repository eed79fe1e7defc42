//! The minimum of finitely many cones: `f(x) = min_i (a_i + L |x - x_i|)`.
//!
//! **Statement.** f is L-Lipschitz, because each cone is. A tree over the `x_i` stores for each node the box of its
//! points and the smallest of its `a_i`. A query skips a node if `least + L dist(box, x)` is not below the smallest
//! value so far.
//!
//! *Skipping is exact, to the last bit.* For a point p of the box, each coordinate of the gap between x and the box is
//! at most as large as the same coordinate of `x - p`, in absolute value. Rounded subtraction, squares, their sums,
//! the root, and multiplication and addition of positive numbers are all monotone. The computed bound of a node is
//! therefore at most the computed value of each of its cones. The result is the smallest computed value of all cones.
//!
//! **Source.** Smoothing and filtering follow Miller and Talmor (reference \[14\] of the paper). **Work and depth.**
//! `O(m log m)` to build. A query costs one step per visited node.

use std::cmp::Ordering;

use septet_geometry::cost::Sweep;
use septet_geometry::evaluation::{At, Reader, Words};
use septet_geometry::point::Point;

use crate::bvh::Bounds;
use crate::executor::{Evaluator, Part, evaluated, in_sequence};

/// A cone, given by its tip and the value there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone<P> {
    /// The tip.
    pub at: P,
    /// The value at the tip. It may be negative.
    pub size: f64,
}

impl<P: Point> Words for Cone<P> {
    fn write(&self, words: &mut Vec<u64>) {
        (At(self.at), self.size).write(words);
    }

    fn read(from: &mut Reader<'_>) -> Self {
        let (At(at), size) = Words::read(from);
        Cone { at, size }
    }
}

/// The maximum number of cones in a leaf.
const LEAF: usize = 4;

#[derive(Clone, Debug)]
struct Node<P> {
    bounds: Bounds<P>,
    least: f64,
    range: (u32, u32),
    /// The right child, or 0 for a leaf. The left child is the next node.
    right: u32,
}

/// Cones with a common slope, and a tree for queries.
#[derive(Clone, Debug)]
pub struct Cones<P> {
    slope: f64,
    tips: Vec<Cone<P>>,
    nodes: Vec<Node<P>>,
}

impl<P: Point> Cones<P> {
    /// Builds a tree over cones of the given slope.
    pub fn new(slope: f64, cones: Vec<Cone<P>>) -> Self {
        let mut tree = Cones { slope, tips: cones, nodes: Vec::new() };
        if !tree.tips.is_empty() {
            tree.build(0, tree.tips.len());
        }
        tree
    }

    /// Returns the cones, in the order of the tree.
    pub fn all(&self) -> &[Cone<P>] {
        &self.tips
    }

    /// Returns the slope L.
    pub fn slope(&self) -> f64 {
        self.slope
    }

    fn build(&mut self, from: usize, to: usize) {
        let cones = &self.tips[from..to];
        let bounds = Bounds::of(cones.iter().map(|c| c.at));
        let least = cones.iter().map(|c| c.size).fold(f64::INFINITY, f64::min);
        let node = self.nodes.len();
        self.nodes.push(Node { bounds, least, range: (from as u32, to as u32), right: 0 });
        if to - from <= LEAF {
            return;
        }
        let axis = widest(cones, &bounds, self.slope);
        let half = usize::midpoint(from, to);
        self.tips[from..to].select_nth_unstable_by(half - from, |a, b| order(a, b, axis));
        self.build(from, half);
        self.nodes[node].right = self.nodes.len() as u32;
        self.build(half, to);
    }

    fn value(&self, cone: &Cone<P>, x: P) -> f64 {
        cone.size + self.slope * (x - cone.at).norm2().sqrt()
    }

    fn bound(&self, node: u32, x: P) -> f64 {
        let node = &self.nodes[node as usize];
        node.least + self.slope * node.bounds.dist2(x).sqrt()
    }

    /// Returns the value at a point. It is infinite if there are no cones.
    pub fn at(&self, x: P) -> f64 {
        self.below(x, f64::INFINITY)
    }

    /// Returns the smaller of a known value and the minimum of the cones.
    pub fn below(&self, x: P, known: f64) -> f64 {
        self.below_counted(x, known, &mut Sweep::default())
    }

    /// Returns [`Cones::below`], and counts the visited nodes and cones.
    pub fn below_counted(&self, x: P, known: f64, visits: &mut Sweep) -> f64 {
        if self.nodes.is_empty() { known } else { self.search(0, x, known, visits) }
    }

    /// Returns `true` if some cone is below a value at the point.
    fn any_below(&self, x: P, value: f64, visits: &mut Sweep) -> bool {
        let mut stack = vec![0];
        while let Some(at) = stack.pop() {
            let node = &self.nodes[at as usize];
            visits.visit();
            if self.bound(at, x) >= value {
                continue;
            }
            if node.right == 0 {
                let cones = &self.tips[node.range.0 as usize..node.range.1 as usize];
                if visits.visit_all(cones).iter().any(|c| self.value(c, x) < value) {
                    return true;
                }
            } else {
                stack.extend([node.right, at + 1]);
            }
        }
        false
    }

    fn search(&self, at: u32, x: P, mut known: f64, visits: &mut Sweep) -> f64 {
        let node = &self.nodes[at as usize];
        visits.visit();
        if node.right == 0 {
            let cones = &self.tips[node.range.0 as usize..node.range.1 as usize];
            return visits.visit_all(cones).iter().map(|c| self.value(c, x)).fold(known, f64::min);
        }
        let (left, right) = ((self.bound(at + 1, x), at + 1), (self.bound(node.right, x), node.right));
        let children = if right.0 < left.0 { [right, left] } else { [left, right] };
        for (bound, child) in children {
            if bound < known {
                known = self.search(child, x, known, visits);
            }
        }
        known
    }

    /// Removes the cones whose tips lie above another cone. They are nowhere minimal.
    ///
    /// # Errors
    /// Returns the error of the machine if it fails.
    pub fn filtered<M: Evaluator<P>>(self, machine: &M) -> Result<Self, M::Error> {
        // The comparison is strict. The last cone in a chain of cones, each above the next, therefore remains.
        let numbers: Vec<u32> = (0..self.tips.len() as u32).collect();
        let stays = evaluated(machine, Part::Sizes, &numbers, |number: u32, own| {
            let Some(cone) = self.tips.get(number as usize) else { return false };
            !in_sequence(own, |visits| self.any_below(cone.at, cone.size, visits))
        })?;
        let kept = self.tips.iter().zip(stays).filter(|(_, stays)| *stays).map(|(cone, _)| *cone);
        Ok(Cones::new(self.slope, kept.collect()))
    }
}

/// Returns the coordinate with the largest spread, multiplied by the slope, or `DIM` if the sizes have a larger
/// spread.
fn widest<P: Point>(cones: &[Cone<P>], bounds: &Bounds<P>, slope: f64) -> usize {
    let largest = cones.iter().map(|c| c.size).fold(f64::NEG_INFINITY, f64::max);
    let smallest = cones.iter().map(|c| c.size).fold(f64::INFINITY, f64::min);
    let extent = bounds.extent();
    let spread = |i: usize| if i < P::DIM { slope * extent.coord(i) } else { largest - smallest };
    (1..=P::DIM).fold(0, |best, i| if spread(i) > spread(best) { i } else { best })
}

/// Compares by a coordinate, or by size if `axis` is `DIM`. The other coordinates and the size break ties, so the order
/// depends only on the set of cones.
fn order<P: Point>(a: &Cone<P>, b: &Cone<P>, axis: usize) -> Ordering {
    let by = |i: usize| {
        if i < P::DIM { a.at.coord(i).total_cmp(&b.at.coord(i)) } else { a.size.total_cmp(&b.size) }
    };
    (0..=P::DIM).map(|i| by((axis + i) % (P::DIM + 1))).fold(Ordering::Equal, Ordering::then)
}
