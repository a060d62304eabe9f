//! Symbols of points, so that groups of them differ without colour.

use super::px;

/// The symbol of a point. All look equally large.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Symbol {
    /// A filled circle, as points have it that need no telling apart.
    Dot,
    /// One of the other shapes, by its number.
    Shape(usize),
}

/// Corners of the shapes, for a dot of radius 1.
const SHAPES: [&[[f64; 2]]; 7] = [
    &[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]],
    &[[0.0, -1.45], [1.3, 0.85], [-1.3, 0.85]],
    &[[0.0, -1.45], [1.25, 0.0], [0.0, 1.45], [-1.25, 0.0]],
    &[[0.0, 1.45], [1.3, -0.85], [-1.3, -0.85]],
    &[[-1.45, 0.0], [0.85, -1.3], [0.85, 1.3]],
    &[[1.45, 0.0], [-0.85, -1.3], [-0.85, 1.3]],
    &[[0.0, -1.8], [0.5, -0.5], [1.8, 0.0], [0.5, 0.5], [0.0, 1.8], [-0.5, 0.5], [-1.8, 0.0], [-0.5, -0.5]],
];

impl Symbol {
    /// How many there are.
    pub const COUNT: usize = SHAPES.len() + 1;

    /// The symbol of a group of points; symbols repeat after [`Symbol::COUNT`].
    #[must_use]
    pub fn of(group: usize) -> Self {
        match group % Self::COUNT {
            0 => Self::Dot,
            k => Self::Shape(k - 1),
        }
    }

    /// Its outline as the `d` of a path, closed.
    pub(crate) fn outline(self, [x, y]: [f64; 2], radius: f64) -> String {
        let Self::Shape(k) = self else {
            let (left, right, y, r) = (px(x - radius), px(x + radius), px(y), px(radius));
            return format!("M{left} {y}A{r} {r} 0 1 0 {right} {y}A{r} {r} 0 1 0 {left} {y}Z");
        };
        let corner = |[dx, dy]: &[f64; 2]| format!("{} {}", px(x + radius * dx), px(y + radius * dy));
        let corners: Vec<String> = SHAPES[k % SHAPES.len()].iter().map(corner).collect();
        format!("M{}Z", corners.join("L"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn exact_groups_have_symbols_of_their_own() {
        let all: BTreeSet<String> =
            (0..Symbol::COUNT).map(|k| Symbol::of(k).outline([10.0, 10.0], 3.0)).collect();
        assert_eq!(all.len(), Symbol::COUNT);
        assert_eq!(Symbol::of(1).outline([10.0, 10.0], 10.0), "M1 1L19 1L19 19L1 19Z");
        assert_eq!(Symbol::of(Symbol::COUNT), Symbol::Dot);
    }
}
