// Counts the caches that reach each tile. A thread for each cache.
#include "common/frame.glsl"
#include "common/dispatch.glsl"
#include "common/cache.glsl"
#include "cache_tiles/tile_box.glsl"
#include "shared/PointCounts.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer Counts { PointCounts point_counts; };
layout(set = 0, binding = 2, std430) readonly buffer CachePlaces { CachePlace cache_places[]; };
layout(set = 0, binding = 3, std430) buffer ReferenceCounts { uint reference_counts[]; };

void main() {
    uint slot = linear_thread();
    uvec2 first, last;
    if (slot >= point_counts.primary_count || !tiles_of(cache_places[slot], first, last)) {
        return;
    }
    for (uint y = first.y; y <= last.y; ++y) {
        for (uint x = first.x; x <= last.x; ++x) {
            atomicAdd(reference_counts[y * tile_count().x + x], 1u);
        }
    }
}
