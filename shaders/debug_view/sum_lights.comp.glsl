// Sums over all lights of a pixel's sub-image: how many contribute, or how the levels share the unshadowed lighting.
// The lights are those of light_volumes with the same response, but visited one by one: no volumes, no blending. A
// workgroup covers a square of one sub-image; it first sorts out the lights that reach none of its surface points.
// One thread per pixel; `first_row` lets a picture be done in several dispatches.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/color.glsl"
#include "common/octahedral.glsl"
#include "common/gbuffer.glsl"
#include "common/lights.glsl"
#include "common/srgb.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
// 0: number of lights; 1: shares of the levels.
layout(constant_id = 0) const uint SHARES = 0u;
layout(set = 0, binding = 1) uniform texture2D depth_image;
layout(set = 0, binding = 2) uniform utexture2D normals_image;
layout(set = 0, binding = 3, std430) readonly buffer MergedLights { GridLight merged_lights[]; };
layout(set = 0, binding = 4, std430) readonly buffer SubImages { uint sub_images[]; };
layout(set = 0, binding = 5, std430) readonly buffer Grid { GridPlacement grid; };
layout(set = 0, binding = 6, rgba32f) uniform writeonly image2D out_values;
// Linear colour: the levels' colours, mixed by their shares.
layout(set = 0, binding = 7, rgba32f) uniform writeonly image2D out_mix;
// First row of pixels within the sub-image; sRGB colours 0xRRGGBB of the levels, then of "no light".
layout(push_constant) uniform Push { uint first_row; uint colors[MAX_LEVEL + 2u]; };

#include "merge/sub_images.glsl"
#include "light_volumes/response.glsl"

const uint GROUP = TILE_SIZE * TILE_SIZE;
const uint BATCH = 4u * GROUP;
// Where the workgroup's surface points are, and which lights of a batch reach that box.
shared vec3 points[GROUP];
shared vec3 shared_box_min;
shared vec3 shared_box_max;
shared uint near_bits[BATCH / 32u];

vec3 linear_color(uint packed_color) { return srgb_decode(unpackUnorm4x8(packed_color).zyx); }

// The box about the points of all threads with a surface; empty without any. All threads call it.
void find_box(bool found, vec3 position_ws) {
    uint lane = gl_LocalInvocationIndex;
    points[lane] = found ? position_ws : vec3(1e30);
    barrier();
    if (lane == 0u) {
        shared_box_min = vec3(1e30);
        shared_box_max = vec3(-1e30);
        for (uint i = 0u; i < GROUP; ++i) {
            shared_box_min = min(shared_box_min, points[i]);
            shared_box_max = max(shared_box_max, points[i].x < 1e29 ? points[i] : vec3(-1e30));
        }
    }
    barrier();
}

// Whether a light can reach a point of the box; the margin keeps rounding from losing one that does.
bool reaches_box(uint light, float radius, uint level) {
    vec3 position = merged_lights[light].position_ws;
    vec3 outside = max(max(shared_box_min - position, position - shared_box_max), vec3(0.0));
    return level == top_level() || dot(outside, outside) <= 4.001 * radius * radius;
}

// Marks in near_bits which of the lights first .. first + BATCH, up to `end`, reach the box. All threads call it.
void mark_near(uint first, uint end, float radius, uint level) {
    uint lane = gl_LocalInvocationIndex;
    barrier();
    if (lane < BATCH / 32u) {
        near_bits[lane] = 0u;
    }
    barrier();
    for (uint i = lane; i < BATCH && first + i < end; i += GROUP) {
        if (reaches_box(first + i, radius, level)) {
            atomicOr(near_bits[i / 32u], 1u << (i % 32u));
        }
    }
    barrier();
}

// What the lights of a batch do at one point: their number in x, their luminance in y.
vec2 sum_near(uint first, vec3 position_ws, vec3 normal, float radius, uint level) {
    vec2 sum = vec2(0.0);
    for (uint word = 0u; word < BATCH / 32u; ++word) {
        for (uint bits = near_bits[word]; bits != 0u; bits &= bits - 1u) {
            uint light = first + 32u * word + uint(findLSB(bits));
            float response = blended_response(position_ws, normal, light, radius, level);
            if (response > 0.0) {
                sum += vec2(1.0, response * luminance(merged_lights[light].flux));
            }
        }
    }
    return sum;
}

void main() {
    uint sub_image = gl_WorkGroupID.z;
    uvec2 in_tile = gl_GlobalInvocationID.xy + uvec2(0u, first_row);
    uvec2 pixel = in_tile * interleave() + uvec2(sub_image % interleave(), sub_image / interleave());
    bool inside = all(lessThan(in_tile, sub_image_size())) && all(lessThan(pixel, image_size()));
    float depth = inside ? texelFetch(depth_image, ivec2(pixel), 0).x : 0.0;
    bool found = depth > 0.0;
    vec3 position_ws = found ? position_from_depth(pixel, depth) : vec3(0.0);
    vec3 normal = found ? unpack_octahedral(texelFetch(normals_image, ivec2(pixel), 0).x) : vec3(0.0);
    find_box(found, position_ws);
    vec2 total = vec2(0.0);
    float level_sum = 0.0;
    vec2 dominant = vec2(-1.0, 0.0);
    vec3 mixed = vec3(0.0);
    for (uint level = first_level(); level <= top_level(); ++level) {
        float radius = alpha() * cell_size(grid.h_top, level);
        uint end = sub_images[SUB_IMAGE_STRIDE * sub_image + level + 1u];
        vec2 sum = vec2(0.0);
        for (uint first = sub_images[SUB_IMAGE_STRIDE * sub_image + level]; first < end; first += BATCH) {
            mark_near(first, end, radius, level);
            sum += found ? sum_near(first, position_ws, normal, radius, level) : vec2(0.0);
        }
        total += sum;
        level_sum += float(level) * sum.y;
        mixed += linear_color(colors[level]) * sum.y;
        dominant = sum.y > dominant.y ? vec2(float(level), sum.y) : dominant;
    }
    if (inside) {
        bool lit = total.y > 0.0;
        vec4 shares = lit ? vec4(level_sum / total.y, dominant.x, dominant.y / total.y, 0.0) : vec4(-1.0, -1.0, 0.0, -1.0);
        imageStore(out_values, ivec2(pixel), SHARES != 0u ? shares : vec4(total.x));
        if (SHARES != 0u) {
            vec3 mean = lit ? mixed / total.y : linear_color(colors[MAX_LEVEL + 1u]);
            imageStore(out_mix, ivec2(pixel), vec4(mean, 1.0));
        }
    }
}
