//! Faces of the unit square or cube, and their tilings by cubes.

use septet_geometry::point::Point;

/// A face of the unit square or cube of any dimension. Its fixed axes are at 0 or 1, and its other axes are free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CubeFace<P> {
    /// The coordinates of the fixed axes. Free axes have 0.
    base: P,
    /// Whether each axis is free.
    free: [bool; 3],
}

impl<P: Point> CubeFace<P> {
    /// Returns all faces of dimension `k`.
    pub fn all(k: usize) -> impl Iterator<Item = CubeFace<P>> {
        (0..3usize.pow(P::DIM as u32)).filter_map(move |mut code| {
            let mut face = CubeFace { base: P::default(), free: [false; 3] };
            for i in 0..P::DIM {
                face.free[i] = code % 3 == 2;
                face.base.set_coord(i, if code % 3 == 1 { 1.0 } else { 0.0 });
                code /= 3;
            }
            (face.axes().count() == k).then_some(face)
        })
    }

    /// Returns the free axes.
    fn axes(&self) -> impl Iterator<Item = usize> + '_ {
        (0..P::DIM).filter(|&i| self.free[i])
    }

    /// Tiles the face by cubes with sides of at most `bound(midpoint)`. Calls `visit` with the midpoint and the side of
    /// each cube.
    pub fn tile(&self, bound: impl Fn(&P) -> f64, mut visit: impl FnMut(P, f64)) {
        let axes: Vec<usize> = self.axes().collect();
        let mut whole = self.base;
        for &i in &axes {
            whole.set_coord(i, 0.5);
        }
        let mut stack = vec![(whole, 1.0)];
        while let Some((middle, side)) = stack.pop() {
            if side <= bound(&middle) || side < 1e-9 {
                visit(middle, side);
                continue;
            }
            for part in 0..1usize << axes.len() {
                let mut child = middle;
                for (bit, &i) in axes.iter().enumerate() {
                    let shift = if part >> bit & 1 == 0 { side / 4.0 } else { -side / 4.0 };
                    child.set_coord(i, middle.coord(i) + shift);
                }
                stack.push((child, side / 2.0));
            }
        }
    }
}
