// Counts the lights of S0 nearest to each vertex of S1. One thread per light.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/lights.glsl"
#include "common/dispatch.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer LightPositions { uvec4 light_positions[]; };
layout(set = 0, binding = 2, std430) readonly buffer Grid { GridPlacement grid; };
layout(set = 0, binding = 3, std430) readonly buffer Occupancy { uint occupancy[]; };
layout(set = 0, binding = 4, std430) readonly buffer Ranks { uint ranks[]; };
layout(set = 0, binding = 5, std430) readonly buffer LevelTable { uint level_table[]; };
layout(set = 0, binding = 6, std430) buffer BucketCounts { uint bucket_counts[]; };

#include "common/level_table.glsl"
#include "common/occupancy.glsl"
#include "light_buckets/nearest_vertex.glsl"

void main() {
    uint light = linear_thread();
    uint bucket = light < grid.light_count ? nearest_vertex(uintBitsToFloat(light_positions[light].xyz)) : NO_LIGHT;
    if (bucket != NO_LIGHT) {
        atomicAdd(bucket_counts[bucket], 1u);
    }
}
