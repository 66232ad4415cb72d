//! Twin of `compaction/count_lights`: the level table.

use std::ops::RangeInclusive;

use crate::light_grid::Levels;
use crate::shared::MAX_LEVEL;

/// Words of the level table.
pub const TABLE_WORDS: usize = 2 * (MAX_LEVEL as usize + 2) + 1;

/// First light and count of each level, then the number of lights that did not fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LevelTable(pub [u32; TABLE_WORDS]);

impl Default for LevelTable {
    fn default() -> Self {
        Self([0; TABLE_WORDS])
    }
}

impl LevelTable {
    /// Index of the first light of a level.
    #[must_use]
    pub fn first(&self, level: u32) -> usize {
        self.0[2 * level as usize] as usize
    }

    /// Number of lights of a level.
    #[must_use]
    pub fn count(&self, level: u32) -> usize {
        self.0[2 * level as usize + 1] as usize
    }

    /// The lights of a level.
    #[must_use]
    pub fn range(&self, level: u32) -> std::ops::Range<usize> {
        self.first(level)..self.first(level) + self.count(level)
    }

    /// Lights that did not fit.
    #[must_use]
    pub fn overflow(&self) -> u32 {
        self.0[TABLE_WORDS - 1]
    }
}

/// Turns the ranks of `counted` levels into the level table.
pub fn count_lights(
    table: &mut LevelTable,
    ranks: &[u32],
    levels: Levels,
    counted: RangeInclusive<u32>,
    capacity: u32,
) {
    let (start, end) = counted.into_inner();
    let mut first = if start == 1 { 0 } else { table.range(start - 1).end as u32 };
    for level in start..=end {
        let count = ranks[levels.end_word(level) as usize] - ranks[levels.first_word(level) as usize];
        let kept = count.min(capacity - first.min(capacity));
        table.0[2 * level as usize] = first;
        table.0[2 * level as usize + 1] = kept;
        table.0[TABLE_WORDS - 1] += count - kept;
        first += kept;
    }
    table.0[2 * (end as usize + 1)] = first;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_levels_with_and_without_room() {
        let levels = Levels::new(2);
        // Level 1 has words 0..9 and level 2 words 10..14.
        let mut ranks = vec![5; 15];
        ranks[0] = 0;
        ranks[9] = 5;
        ranks[10] = 5;
        ranks[14] = 8;
        let mut table = LevelTable::default();
        count_lights(&mut table, &ranks, levels, 1..=2, 100);
        assert_eq!((table.range(1), table.range(2), table.first(3), table.overflow()), (0..5, 5..8, 8, 0));
        let mut table = LevelTable::default();
        count_lights(&mut table, &ranks, levels, 1..=1, 6);
        count_lights(&mut table, &ranks, levels, 2..=2, 6);
        assert_eq!((table.range(1), table.range(2), table.overflow()), (0..5, 5..6, 2));
    }
}
