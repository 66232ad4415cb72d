// The merged list: per sub-image, per level. TILE_STRIDE entries per sub-image in `tiles`.
const uint TILE_STRIDE = MAX_LEVEL + 2u;

// Lights of a level with `count` lights that sub-image `tile` of `tile_count` gets.
uint dealt_count(uint count, uint tile, uint tile_count) {
    return count < tile_count ? count : (count - tile + tile_count - 1u) / tile_count;
}
