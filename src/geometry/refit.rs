//! The tree of an earlier state of the same objects, fitted to where they are now: what one object's move needs, in a twentieth of the time
//! that a tree takes to build.

use super::bounds::Bounds;
use super::bvh::Tree;
use super::node::{LEAF, WIDTH};

/// A tree is fitted only as long as rays are expected to cost at most this many times what they did when it was built.
const WORTH_KEEPING: f64 = 1.05;

impl Tree {
    /// This tree over other boxes of the same primitives, those of each leaf slot given by `primitives_of`. `None` where so much has moved that a
    /// tree built anew would be quicker to walk.
    pub(super) fn refitted<P>(&self, bounds: &[Bounds], primitives_of: impl Fn(u32) -> P) -> Option<Self>
    where
        P: Iterator<Item = u32>,
    {
        let mut nodes = self.nodes.clone();
        // Without margins, which would otherwise add up from level to level.
        let mut around = vec![Bounds::EMPTY; nodes.len()];
        // A node comes before its children.
        for index in (0..nodes.len()).rev() {
            let node = &mut nodes[index];
            for lane in (0..WIDTH).filter(|lane| self.nodes[index].is_used(*lane)) {
                let child = node.children[lane];
                let child_bounds = match child & LEAF {
                    0 => around[child as usize],
                    _ => primitives_of(child & !LEAF).fold(Bounds::EMPTY, |a, p| a.union(bounds[p as usize])),
                };
                node.set_box(lane, child_bounds);
                around[index] = around[index].union(child_bounds);
            }
        }
        let tree = Self { nodes, cost_as_built: self.cost_as_built, ..Self::around(*around.first()?) };
        (tree.cost() <= WORTH_KEEPING * self.cost_as_built).then_some(tree)
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};

    use super::*;

    /// Points of a small grid, moved each by a share of its distance to its neighbours, or some of them far away.
    fn boxes(moved: f32, is_thrown: impl Fn(usize) -> bool) -> Vec<Bounds> {
        let irregular =
            |index: usize, salt: u32| ((index as u32 + salt).wrapping_mul(0x9E37_79B9) >> 8) as f32 / (1 << 24) as f32;
        (0..4096)
            .map(|index| {
                let at = Vec3::from_array([index % 16, index / 16 % 16, index / 256].map(|x| x as f32));
                let by = Vec3::from_array([1, 2, 3].map(|salt| irregular(index, salt) * moved));
                let thrown = if is_thrown(index) { 40.0 * irregular(index, 4) } else { 0.0 };
                let min = at + by + thrown * Vec3::new(-1.0, 0.3, 1.0);
                Bounds { min, max: min + 0.5 }
            })
            .collect()
    }

    fn found(tree: &Tree, primitives: impl Fn(u32) -> u32, min: DVec3, max: DVec3) -> Vec<u32> {
        let mut found = Vec::new();
        let _ = tree.visit_box(min, max, u32::MAX, |slot| {
            found.push(primitives(slot));
            std::ops::ControlFlow::Continue(())
        });
        found.sort_unstable();
        found
    }

    #[test]
    fn a_fitted_tree_finds_what_one_built_anew_finds() {
        let of = vec![0; 4096];
        let before = boxes(0.1, |_| false);
        let (tree, slots) = Tree::build(&before, &of, 1);
        assert!(tree.cost() == tree.cost_as_built && tree.cost_as_built > 0.0);
        for after in [before.clone(), boxes(0.2, |_| false), boxes(0.1, |index| index == 77)] {
            let fitted = tree.refitted(&after, |slot| slots.primitives_of(slot)).expect("little has moved");
            let (anew, slots_anew) = Tree::build(&after, &of, 1);
            assert_eq!((fitted.center, fitted.radius), (anew.center, anew.radius));
            let mut met = 0;
            for corner in
                (0..50).map(|k| DVec3::new(f64::from(k % 5) * 3.3, f64::from(k / 5) * 1.7, f64::from(k % 7) * 2.1))
            {
                let (min, max) = (corner - 0.7, corner + DVec3::new(0.3, 0.9, 0.6));
                let expected = found(&anew, |slot| slots_anew.primitives[slot as usize], min, max);
                assert_eq!(found(&fitted, |slot| slots.primitives[slot as usize], min, max), expected);
                met += expected.len();
            }
            assert!(met > 50, "{met}");
        }
    }

    #[test]
    fn what_has_moved_much_is_built_anew() {
        let (tree, slots) = Tree::build(&boxes(0.1, |_| false), &vec![0; 4096], 1);
        for after in [boxes(3.0, |_| false), boxes(0.1, |index| index % 3 == 0)] {
            assert!(tree.refitted(&after, |slot| slots.primitives_of(slot)).is_none());
        }
        assert!(Tree::default().refitted(&[], |_| std::iter::empty()).is_none());
    }
}
