// level_table: [2 l] index of the first light of level l in the grid lights, [2 l + 1] number of them.
uint level_first(uint level) { return level_table[2u * level]; }
uint level_count(uint level) { return level_table[2u * level + 1u]; }
