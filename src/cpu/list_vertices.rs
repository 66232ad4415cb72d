//! Twin of `compaction/list_vertices`.

use std::ops::RangeInclusive;

use super::count_lights::LevelTable;
use crate::light_grid::Levels;
use crate::shared::GridLight;

/// Notes vertex and level of every occupied vertex at its place among the grid lights.
pub fn list_vertices(
    lights: &mut [GridLight],
    occupancy: &[u32],
    ranks: &[u32],
    table: &LevelTable,
    levels: Levels,
    marked: RangeInclusive<u32>,
) {
    for level in marked {
        let first_word = levels.first_word(level);
        for word in first_word..levels.end_word(level) {
            let row = (word - first_word) / levels.words_per_row(level);
            let column = (word - first_word) % levels.words_per_row(level);
            let rank = ranks[word as usize] - ranks[first_word as usize];
            let set = (0..32).filter(|bit| occupancy[word as usize] >> bit & 1 == 1);
            for (target, bit) in (table.first(level) + rank as usize..).zip(set) {
                if let Some(light) = lights.get_mut(target) {
                    light.vertex = row * levels.vertices_per_axis(level) + column * 32 + bit;
                    light.level = level;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::count_lights::count_lights;
    use super::super::exclusive_scan::exclusive_scan;
    use super::*;

    #[test]
    fn three_vertices_of_two_levels() {
        let levels = Levels::new(2);
        let mut occupancy = vec![0; 15];
        occupancy[1] = 0b110;
        occupancy[12] = 0b10;
        let ranks = exclusive_scan(&occupancy);
        let mut table = LevelTable::default();
        count_lights(&mut table, &ranks, levels, 1..=2, 9);
        let mut lights = vec![bytemuck::Zeroable::zeroed(); 3];
        list_vertices(&mut lights, &occupancy, &ranks, &table, levels, 1..=2);
        let found: Vec<_> = lights.iter().map(|l: &GridLight| (l.level, l.vertex)).collect();
        assert_eq!(found, [(1, 4), (1, 5), (2, 5)]);
    }
}
