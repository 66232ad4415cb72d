// The rounds of shadow samples in a frame: further ones (ROUND) are for pixels whose history is still short, and each counts as
// a frame of it. Needs frame.glsl. What takes part (ROUND) or lists what does in the next round (LISTS_TILES)
// declares `enough_frames`.
#if defined(ROUND) || defined(LISTS_TILES)

// What is enough in a frame that follows others: from so many frames on the noise of their mean is known.
const float ENOUGH_WITH_HISTORY = 4.0;
// Words before the tiles in a list: a dispatch with a workgroup for each, in rows like those of the picture, and their number.
const uint LIST_HEADER = 4u;

// Whether a pixel with so many frames takes part; none are where there is no surface. Half a frame less is enough, as means of
// numbers of frames are seldom whole.
bool is_short(float frames) {
    float enough = frame.history_is_valid != 0u ? min(enough_frames, ENOUGH_WITH_HISTORY) : enough_frames;
    return frames > 0.0 && frames < enough - 0.5;
}

uint tile_columns() { return (image_size().x + TILE_SIZE - 1u) / TILE_SIZE; }

#endif

#ifdef ROUND

// Of this round; as the order is that in which workgroups came, nothing may depend on it.
layout(set = 0, binding = ROUND_TILES_BINDING, std430) readonly buffer RoundTiles { uint round_tiles[]; };

uint list_index() { return gl_WorkGroupID.y * tile_columns() + gl_WorkGroupID.x; }

// Whether there is a tile for this workgroup.
bool has_tile() { return list_index() < round_tiles[LIST_HEADER - 1u]; }

uvec2 pixel_in_tile() {
    uint tile = round_tiles[LIST_HEADER + list_index()];
    return uvec2(tile % tile_columns(), tile / tile_columns()) * TILE_SIZE + gl_LocalInvocationID.xy;
}

#endif

#ifdef LISTS_TILES

layout(set = 0, binding = 13, std430) buffer NextTiles { uint next_tiles[]; };

shared uint has_short;

// Lists a tile for the next round if any of its pixels is short; all threads of the tile must call.
void list_tile(uvec2 tile, bool is_short_here) {
    if (gl_LocalInvocationIndex == 0u) {
        has_short = 0u;
    }
    barrier();
    if (is_short_here) {
        atomicOr(has_short, 1u);
    }
    barrier();
    if (has_short != 0u && gl_LocalInvocationIndex == 0u) {
        uint index = atomicAdd(next_tiles[LIST_HEADER - 1u], 1u);
        next_tiles[LIST_HEADER + index] = tile.y * tile_columns() + tile.x;
        atomicMax(next_tiles[0], tile_columns());
        atomicMax(next_tiles[1], index / tile_columns() + 1u);
        atomicMax(next_tiles[2], 1u);
    }
}

#endif
