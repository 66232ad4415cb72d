//! The shape of the grid hierarchy: levels, vertices, and where each level's occupancy bits lie.

pub mod anchor;
pub mod choose_levels;

use crate::shared::{LEVEL_ROWS, MAX_LEVEL, MIN_TOP_LEVEL};

/// The levels 1..=Lmax. Level Lmax has 2 vertices per axis, each level below twice the cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Levels {
    /// Lmax.
    pub top: u32,
}

impl Levels {
    /// Lmax is clamped to what the tables hold, [`MIN_TOP_LEVEL`]..=[`MAX_LEVEL`].
    #[must_use]
    pub fn new(top: u32) -> Self {
        Self { top: top.clamp(MIN_TOP_LEVEL, MAX_LEVEL) }
    }

    /// Vertices per axis of a level: 2^(Lmax - l) + 1.
    #[must_use]
    pub fn vertices_per_axis(self, level: u32) -> u32 {
        (1 << (self.top - level)) + 1
    }

    /// Words of occupancy bits per row of vertices along x.
    #[must_use]
    pub fn words_per_row(self, level: u32) -> u32 {
        self.vertices_per_axis(level).div_ceil(32)
    }

    fn word_count(self, level: u32) -> u32 {
        self.vertices_per_axis(level).pow(2) * self.words_per_row(level)
    }

    /// Words of all levels before `level`, with one empty word after each level so that every level has a rank
    /// past its end.
    #[must_use]
    pub fn first_word(self, level: u32) -> u32 {
        (1..level).map(|l| self.word_count(l) + 1).sum()
    }

    /// One past the last word of `level`.
    #[must_use]
    pub fn end_word(self, level: u32) -> u32 {
        self.first_word(level) + self.word_count(level)
    }

    /// Words of all levels together.
    #[must_use]
    pub fn total_words(self) -> u32 {
        self.first_word(self.top + 1)
    }

    /// The table that shaders read: vertices per axis, words per row, first word, end word.
    #[must_use]
    pub fn table(self) -> [[u32; 4]; LEVEL_ROWS] {
        let mut rows = [[0; 4]; LEVEL_ROWS];
        for level in 1..=self.top {
            rows[level as usize] = [
                self.vertices_per_axis(level),
                self.words_per_row(level),
                self.first_word(level),
                self.end_word(level),
            ];
        }
        rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_double_and_top_has_eight_vertices() {
        let levels = Levels::new(7);
        assert_eq!(levels.vertices_per_axis(7), 2);
        assert_eq!(levels.vertices_per_axis(6), 3);
        assert_eq!(levels.vertices_per_axis(1), 65);
        assert_eq!(levels.words_per_row(1), 3);
        assert_eq!(levels.words_per_row(3), 1);
        assert_eq!(levels.end_word(1), 65 * 65 * 3);
        assert_eq!(levels.first_word(2), 65 * 65 * 3 + 1);
        assert_eq!(levels.total_words(), levels.end_word(7) + 1);
    }
}
