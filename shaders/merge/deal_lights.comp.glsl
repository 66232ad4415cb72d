// How many lights of each used level every sub-image gets, where they go in the merged list, and the indirect
// draws. One thread. With n x n sub-images the lights of a level are dealt evenly; a level with fewer than n^2
// lights goes to all (section 4.1).
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/lights.glsl"

layout(local_size_x = 1) in;
layout(set = 0, binding = 1, std430) readonly buffer LevelTable { uint level_table[]; };
layout(set = 0, binding = 2, std430) readonly buffer LightCounts { uint light_counts[]; };
// sub_images[SUB_IMAGE_STRIDE * t + l]: first merged light of level l for sub-image t; the entry after Lmax ends the list.
layout(set = 0, binding = 3, std430) writeonly buffer SubImages { uint sub_images[]; };
// VkDrawIndirectCommand per sub-image: a volume for every light below the top level.
layout(set = 0, binding = 4, std430) writeonly buffer Draws { uint draws[]; };
// Workgroups of WORKGROUP_SIZE over all lights that are merged.
layout(set = 0, binding = 5, std430) writeonly buffer MergeDispatch { uint merge_dispatch[]; };

#include "common/level_table.glsl"
#include "merge/sub_images.glsl"

uint lights_in(uint level) { return level == 0u ? light_counts[0] : level_count(level); }

void main() {
    uint sub_image_count = interleave() * interleave();
    uint next = 0u;
    for (uint sub_image = 0u; sub_image < sub_image_count; ++sub_image) {
        uint first = next;
        uint top_first = next;
        for (uint level = first_level(); level <= top_level(); ++level) {
            top_first = next;
            sub_images[SUB_IMAGE_STRIDE * sub_image + level] = next;
            next += dealt_count(lights_in(level), sub_image, sub_image_count);
        }
        sub_images[SUB_IMAGE_STRIDE * sub_image + top_level() + 1u] = next;
        draws[4u * sub_image] = LIGHT_VOLUME_VERTICES;
        draws[4u * sub_image + 1u] = top_first - first;
        draws[4u * sub_image + 2u] = 0u;
        draws[4u * sub_image + 3u] = 0u;
    }
    uint total = level_first(top_level()) + level_count(top_level()) + (first_level() == 0u ? light_counts[0] : 0u);
    uint groups = (total + WORKGROUP_SIZE - 1u) / WORKGROUP_SIZE;
    uint x = clamp(groups, 1u, DISPATCH_WIDTH);
    merge_dispatch[0] = x;
    merge_dispatch[1] = (groups + x - 1u) / x;
    merge_dispatch[2] = 1u;
}
