//! Sides of the points' tree: twin of `common/points.glsl` and `point_selection/side_bits.glsl`, one side at a time.

/// Which nodes of a tree oppose their parents.
#[derive(Clone, Debug)]
pub struct PointSides {
    /// Number of leaves, a power of two.
    pub leaf_count: u32,
    /// A bit for each node.
    pub turned_bits: Vec<u32>,
}

/// Whether a bit of a set is set.
#[must_use]
pub fn has_bit(bits: &[u32], index: u32) -> bool {
    bits[index as usize / 32] >> (index % 32) & 1 == 1
}

/// Sets a bit of a set.
pub fn set_bit(bits: &mut [u32], index: u32) {
    bits[index as usize / 32] |= 1 << (index % 32);
}

impl PointSides {
    /// All keys, parents before their children.
    pub fn keys(&self) -> std::ops::Range<u32> {
        2..4 * self.leaf_count
    }

    /// A set of sides that has none.
    #[must_use]
    pub fn none(&self) -> Vec<u32> {
        vec![0; (4 * self.leaf_count).div_ceil(32) as usize]
    }

    /// Whether a side belongs to a leaf.
    #[must_use]
    pub fn is_leaf(&self, key: u32) -> bool {
        key / 2 >= self.leaf_count
    }

    fn turned(&self, node: u32) -> u32 {
        has_bit(&self.turned_bits, node).into()
    }

    /// The side of the parent that faces as this one does; below 2 for the root's.
    #[must_use]
    pub fn parent(&self, key: u32) -> u32 {
        let node = key / 2;
        node / 2 * 2 + ((key % 2) ^ self.turned(node))
    }

    /// The sides of the children that face as this one does.
    #[must_use]
    pub fn children(&self, key: u32) -> [u32; 2] {
        [0, 1].map(|child| {
            let node = key / 2 * 2 + child;
            2 * node + ((key % 2) ^ self.turned(node))
        })
    }
}

#[cfg(test)]
pub(crate) mod testing {
    use super::PointSides;
    use crate::random::hash3;

    /// A set of random bits, each set with probability `share`.
    pub fn random_bits(count: u32, share: f32, seed: u32) -> Vec<u32> {
        let bit = |index: u32| u32::from(crate::random::unit_float(hash3(index, seed, 7)) < share);
        (0..count.div_ceil(32)).map(|word| (0..32).fold(0, |bits, i| bits | bit(32 * word + i) << i)).collect()
    }

    /// A tree of which a third of the nodes oppose their parents.
    pub fn random_sides(leaf_count: u32, seed: u32) -> PointSides {
        PointSides { leaf_count, turned_bits: random_bits(2 * leaf_count, 0.3, seed) }
    }

    #[test]
    fn children_lead_back_to_their_parent() {
        let sides = random_sides(64, 1);
        for key in sides.keys().filter(|key| !sides.is_leaf(*key)) {
            assert_eq!(sides.children(key).map(|child| sides.parent(child)), [key; 2]);
        }
    }
}
