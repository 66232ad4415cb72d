// Lists the caches that reach each tile, in any order. Counts down what was counted up. A thread for each cache.
#include "common/frame.glsl"
#include "common/dispatch.glsl"
#include "common/cache.glsl"
#include "cache_tiles/tile_box.glsl"
#include "shared/PointCounts.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer Counts { PointCounts point_counts; };
layout(set = 0, binding = 2, std430) readonly buffer CachePlaces { CachePlace cache_places[]; };
layout(set = 0, binding = 3, std430) buffer ReferenceCounts { uint reference_counts[]; };
layout(set = 0, binding = 4, std430) readonly buffer ReferenceStarts { uint reference_starts[]; };
layout(set = 0, binding = 5, std430) writeonly buffer References { uint cache_references[]; };

void main() {
    uint slot = linear_thread();
    uvec2 first, last;
    if (slot >= point_counts.primary_count || !tiles_of(cache_places[slot], first, last)) {
        return;
    }
    for (uint y = first.y; y <= last.y; ++y) {
        for (uint x = first.x; x <= last.x; ++x) {
            uint tile = y * tile_count().x + x;
            uint index = reference_starts[tile] + atomicAdd(reference_counts[tile], 0xffffffffu) - 1u;
            if (index < uint(cache_references.length())) {
                cache_references[index] = slot;
            }
        }
    }
}
