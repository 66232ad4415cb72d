// Irradiance of the secondary points that need it: from the environment by a micro-buffer that is not kept, as only what is
// not covered counts, of rays or with MICRO_POINTS of points; from suns and lamps by rays. With KEEPS_KEYS what covers the texels
// is kept, for more bounces; with GATHERS_LIGHTS light of the lighting grid hierarchy is added. A workgroup for each.
#include "common/frame.glsl"
#include "common/dispatch.glsl"
#include "common/random.glsl"
#ifdef GATHERS_LIGHTS
#include "common/color.glsl"
#endif
#include "common/octahedral.glsl"
#include "common/scene.glsl"
#include "common/punctual.glsl"
#include "common/environment.glsl"
#include "common/emitters.glsl"
#include "common/environment_means.glsl"
#include "common/micro_buffer.glsl"
#include "common/point_leaves.glsl"
#include "common/point_sum.glsl"
#include "shared/PointCounts.glsl"

layout(local_size_x = POINT_LANES) in;
#ifdef ALL_LEAVES
layout(push_constant) uniform Push { uint round; uint part; };

// The key of this workgroup, 0 beyond the last: all sides of leaves, in parts.
uint key_of_group() {
    uint index = part * KEYS_PER_PART + gl_WorkGroupID.x;
    return index < 2u * frame.point_leaf_count ? 2u * frame.point_leaf_count + index : 0u;
}
#else
layout(set = 0, binding = 3, std430) readonly buffer Counts { PointCounts point_counts; };
layout(set = 0, binding = 4, std430) readonly buffer Needed { uint point_needed[]; };

uint key_of_group() { return linear_group() < point_counts.needed_count ? point_needed[linear_group()] : 0u; }
#endif
layout(set = 0, binding = 5, std430) buffer Irradiance { float point_irradiance[]; };
#include "common/point_irradiance.glsl"

#if defined(MICRO_POINTS) || defined(ALL_LEAVES)
// Lit at their representative leaves.
uvec4 words_of(uint key) { return uvec4(NO_LEAF); }
PointPlace place_of_word(uint word) { return PointPlace(vec3(0.0), vec3(0.0)); }
#else
layout(set = 0, binding = 6, std430) readonly buffer SeenTexels { uvec4 seen_texels[]; };
layout(set = 0, binding = 7, std430) readonly buffer Primaries { uint point_primaries[]; };
layout(set = 0, binding = 8, std430) readonly buffer PrimaryLeaves { uvec4 primary_leaves[]; };
layout(set = 0, binding = 9, std430) readonly buffer PrimaryTable { MicroTexel primary_table[]; };
#include "common/seen_places.glsl"

// Where the ray of a primary point's texel hits, on the side that it hits.
PointPlace place_of_word(uint word) {
    uint texel = unpack_texel(word);
    uint slot = texel / PRIMARY_TEXELS;
    uint key = point_primaries[slot];
    PointPlace place = place_of_point(key, primary_leaves[slot]);
    vec3 direction = micro_frame(place.normal_ws, key) * primary_table[texel % PRIMARY_TEXELS].direction;
    Hit hit;
    if (!traverse(place.position_ws, direction, 3e38, false, hit)) {
        return place;
    }
    BvhTriangle tri = bvh_triangle(hit.bvh_triangle);
    vec3 normal = direction_or(cross(tri.edge1, tri.edge2), direction);
    normal = dot(normal, direction) < 0.0 ? normal : -normal;
    return place_above(place.position_ws + hit.t * direction, normal);
}

uvec4 words_of(uint key) { return seen_texels[key]; }
#endif
#include "common/point_light.glsl"
#ifdef GATHERS_LIGHTS
#include "point_light/hierarchy_light.glsl"
#else
// The first bounce is all.
vec3 hierarchy_irradiance(uint key, uint place_count, uint lane) { return vec3(0.0); }
#endif

#ifdef MICRO_POINTS
layout(constant_id = 0) const uint BINARY_COVERAGE = 0u;
#define MICRO_EDGE SECONDARY_EDGE
#ifdef KEEPS_KEYS
#define MICRO_KEYS
#endif
#include "micro_buffers/splat.glsl"

// Share of a texel that nothing covers, once the micro-buffer is filled.
float openness(PointPlace place, uint texel, vec3 direction) { return 1.0 - micro_coverage(texel); }
#else
// Whether nothing covers a texel.
float openness(PointPlace place, uint texel, vec3 direction) {
    return is_open(place.position_ws, direction) ? 1.0 : 0.0;
}
#endif

#ifdef KEEPS_KEYS
layout(set = 0, binding = 13, std430) writeonly buffer SecondaryTexels { uint secondary_texels[]; };
#ifdef MICRO_POINTS
// What a texel sees, once the micro-buffer is filled, as it is kept.
uint seen_texel(uint key, PointPlace place, uint texel, vec3 direction) {
    return pack_micro_texel(micro_coverage(texel), micro_key(texel));
}
#else
layout(set = 0, binding = 11, std430) readonly buffer TriangleCells { uvec2 triangle_cells[]; };
layout(set = 0, binding = 12, std430) readonly buffer LeafCells { uint leaf_cells[]; };
#include "common/point_hits.glsl"
#include "common/hit_key.glsl"
#include "common/seen_key.glsl"

// What a texel sees, as it is kept.
uint seen_texel(uint key, PointPlace place, uint texel, vec3 direction) {
    Hit hit;
    if (!traverse(place.position_ws, direction, 3e38, false, hit)) {
        return 0u;
    }
    float solid_angle = micro_table[texel].solid_angle;
    float radius = point_node(key >> 1u).radius;
    return pack_micro_texel(1.0, seen_key(hit_key(hit, direction), place.position_ws, solid_angle, radius));
}
#endif

// Keeps what a texel sees where there is room.
void keep_texel(uint texel, uint seen) {
    uint index = SECONDARY_TEXELS * linear_group() + texel;
    if (index < uint(secondary_texels.length())) {
        secondary_texels[index] = seen;
    }
}

// Share of a texel that nothing covers; keeps what it sees.
float open_share(uint key, PointPlace place, uint texel, vec3 direction) {
    uint seen = seen_texel(key, place, texel, direction);
    keep_texel(texel, seen);
    return 1.0 - coverage_of(seen);
}
const bool LOOKS_EVERYWHERE = true;
#else
float open_share(uint key, PointPlace place, uint texel, vec3 direction) { return openness(place, texel, direction); }
void keep_texel(uint texel, uint seen) {}
// Where nothing comes from nobody needs to know what is there.
const bool LOOKS_EVERYWHERE = false;
#endif

// Share of a lane of what comes from the environment; its texels look from the places in turns.
vec3 sky_irradiance(uint key, uint place_count, uint lane) {
    vec3 sum = vec3(0.0);
    for (uint i = lane; i < SECONDARY_TEXELS; i += POINT_LANES) {
        MicroTexel texel = micro_table[i];
        // Two by two, so that each place looks everywhere.
        PointPlace place = lit_places[((i & 1u) + 2u * (i / SECONDARY_EDGE & 1u)) % place_count];
        vec3 direction = micro_frame(place.normal_ws, key) * texel.direction;
        vec3 radiance = environment_mean(direction, texel.environment_level);
        if (is_used(texel) && (LOOKS_EVERYWHERE || any(greaterThan(radiance, vec3(0.0))))) {
            sum += open_share(key, place, i, direction) * texel.cosine_weight * radiance;
        } else {
            keep_texel(i, 0u);
        }
    }
    return sum;
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint key = key_of_group();
    if (key == 0u) {
        return;
    }
    uint places = find_lit_places(words_of(key), key, lane);
#ifdef MICRO_POINTS
    fill_micro_buffer(MicroEye(lit_places[0].position_ws, micro_frame(lit_places[0].normal_ws, key)), lane);
#endif
    vec3 irradiance = sky_irradiance(key, places, lane) + lamp_irradiance(places, lane, POINT_LANES) +
                      emitter_light_at_places(key, places, lane, POINT_LANES) +
                      hierarchy_irradiance(key, places, lane);
    irradiance = sum_over_lanes(lane, irradiance);
    if (lane == 0u) {
        set_irradiance(key, irradiance);
    }
}
