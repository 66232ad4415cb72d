// Light paths from suns, spots, points, surfaces that shine and the environment; a VPL at every diffuse hit. One thread per
// path; path p writes VPL b to slot p * bounces + b and sets that slot's bit, so that the result does not depend on scheduling.
// Where there are too many slots, paths go in parts, and the slots of a part are in memory.
// Three numbers between 0 and 1 say where a path starts: the light, and two for it. They are drawn from cells, each with
// its share of the paths, and what a path carries is divided by the density of its cell.
// Reads the scene. Keller 1997; Lin and Yuksel 2019, section 4.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/octahedral.glsl"
#include "common/scene.glsl"
#include "common/punctual.glsl"
#include "common/environment.glsl"
#include "common/emitters.glsl"
#include "common/dispatch.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 1, std430) writeonly buffer SlotPositions { uvec4 slot_positions[]; };
layout(set = 0, binding = 2, std430) writeonly buffer SlotFluxes { vec4 slot_fluxes[]; };
layout(set = 0, binding = 3, std430) buffer SlotBits { uint slot_bits[]; };
layout(set = 0, binding = 4, std430) buffer RayCount { uint ray_count[]; };
#include "shared/StartCell.glsl"
layout(set = 0, binding = 5, std430) readonly buffer StartCells { StartCell start_cells[]; };

layout(push_constant) uniform Push { uint first_path; uint end_path; };

#include "common/path_starts.glsl"

float share_before(uint cell) { return start_cells[cell].first; }

DEFINE_INTERVAL_SEARCH(start_cell, share_before)

// Which one of the paths of all frames this is. Where paths are renewed a few at a time, a frame's paths are successive ones.
uint path_of_all_frames(uint path) {
    uint count = frame.path_count;
    return frame.renewed_paths == 0u ? path : path + count * ((frame.renewed_paths - path + count - 1u) / count);
}

// Three numbers between 0 and 1, which over the paths of a frame spread evenly.
vec3 spread_numbers(uint path, uint path_of_all, inout uint random_state) {
    if (frame.renewed_paths == 0u) {
        float share = (float(path) + random(random_state)) / float(frame.path_count);
        return vec3(share, r2_sequence(path, frame_seed()));
    }
    return r3_sequence(path_of_all, frame_seed());
}

void main() {
    uint path = first_path + linear_thread();
    if (path >= end_path) {
        return;
    }
    uint path_of_all = path_of_all_frames(path);
    uint random_state = hash(path_of_all, frame_seed());
    vec3 numbers = spread_numbers(path, path_of_all, random_state);
    StartCell cell = start_cells[start_cell(0u, uint(start_cells.length()), numbers.x)];
    numbers.x = clamp((numbers.x - cell.first) / cell.share, 0.0, 1.0);
    vec3 start = cell.low + cell.size * numbers;
    Emission emission;
    if (is_environment(start.x)) {
        emission = emit_from_environment(start.yz, vec2(random(random_state), random(random_state)));
    } else {
        PunctualLight light = lamp_at(start.x);
        if (light.kind == LIGHT_EMITTERS) {
            emission = emit_from_surface(light, start.yz, vec2(random(random_state), random(random_state)));
        } else {
            emission = emit_path(light, start.yz);
        }
    }
    vec3 origin = emission.origin;
    vec3 direction = emission.direction;
    vec3 flux = emission.flux * (cell.size.x * cell.size.y * cell.size.z / cell.share);
    uint rays = 0u;
    for (uint bounce = 0u; bounce < frame.bounces; ++bounce) {
        Hit hit;
        ++rays;
        if (!any(greaterThan(flux, vec3(0.0))) || !traverse(origin, direction, 3e38, false, hit)) {
            break;
        }
        HitSurface surface = surface_at_hit(hit, direction);
        flux *= surface.albedo;
        uint slot = path * frame.bounces + bounce;
        if (any(greaterThan(flux, vec3(0.0)))) {
            uint place = slot - first_path * frame.bounces;
            slot_positions[place] = uvec4(floatBitsToUint(surface.position_ws), pack_octahedral(surface.normal));
            slot_fluxes[place] = vec4(flux, 1.0);
            atomicOr(slot_bits[slot / 32u], 1u << (slot % 32u));
        }
        origin = surface.position_ws + surface.geometric * ray_offset(surface.position_ws);
        direction = cosine_direction(surface.normal, vec2(random(random_state), random(random_state)));
        if (dot(direction, surface.geometric) <= 0.0) {
            break;
        }
    }
    atomicAdd(ray_count[0], rays);
}
