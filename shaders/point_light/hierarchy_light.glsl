// Light of the lighting grid hierarchy at points, which has all bounces of what lights the scene. Each lane sums the lights of
// some of the rows of vertices in reach, picks one of them by what it may send, and casts a shadow ray to one of the lights S0 that
// it is made of. Needs point_light.glsl, color.glsl and emitters.glsl.
#include "common/lights.glsl"
#include "common/original_lights.glsl"

layout(set = 0, binding = 14, std430) readonly buffer LevelTable { uint level_table[]; };
layout(set = 0, binding = 15, std430) readonly buffer Descent { uint descent[]; };
layout(set = 0, binding = 16, std430) readonly buffer Representatives { uint representatives[]; };
layout(set = 0, binding = 17, std430) readonly buffer LightPositions { uvec4 light_positions[]; };
layout(set = 0, binding = 18, std430) readonly buffer LightFluxes { vec4 light_fluxes[]; };
layout(set = 0, binding = 19, std430) readonly buffer Grid { GridPlacement grid; };
layout(set = 0, binding = 20, std430) readonly buffer Occupancy { uint occupancy[]; };
layout(set = 0, binding = 21, std430) readonly buffer Ranks { uint ranks[]; };
layout(set = 0, binding = 22, std430) readonly buffer GridLights { GridLight grid_lights[]; };
layout(push_constant) uniform Push { uint index_bits; };

#include "common/level_table.glsl"
#include "common/vertex_rows.glsl"
#include "descent/tables.glsl"
#include "descent/representatives.glsl"
#include "descent/way_down.glsl"

// What a lane has found so far.
struct Found {
    // Of lights that get no shadow rays: radiance per unit albedo.
    vec3 unshadowed;
    // Luminance of what the others may send, and one of them, chosen by its share in that.
    float total;
    uint light;
};

// The vertices of a level whose lights may reach a position: a grid light lies within a cell of its vertex.
VertexRows rows_in_reach(vec3 position_ws, uint level) {
    vec3 cells = (position_ws - grid.origin_ws) / cell_size(grid.h_top, level);
    vec3 last = vec3(float(vertices_per_axis(level) - 1u));
    float reach = 2.0 * alpha() + 1.001;
    vec3 low = clamp(ceil(cells - reach), vec3(0.0), last + 1.0);
    vec3 high = clamp(floor(cells + reach), vec3(-1.0), last);
    if (level == top_level()) {
        low = vec3(0.0);
        high = last;
    }
    return vertex_rows(level, uvec3(low), uvec3(max(high - low + 1.0, vec3(0.0))));
}

// Share of what a light would send if it and the place faced each other that it is chosen for at least: the lights S0 that it is
// made of may face where it does not.
const float LEAST_FACING = 0.125;

// What a light is chosen for, per unit of flux, of which it sends `response`.
float chosen_response(GridLight light, PointPlace place, float response) {
    vec3 offset = light.position_ws - place.position_ws;
    vec3 spread = max(light.variance, vec3(0.0));
    float distance_squared = dot(offset, offset) + spread.x + spread.y + spread.z;
    return response + LEAST_FACING / (PI * PI * max(distance_squared, max(clamp_squared(), 1e-30)));
}

void add_light(PointPlace place, uint index, uint level, inout Found found, inout uint random_state) {
    GridLight light = grid_lights[index];
    float distance = length(light.position_ws - place.position_ws);
    float radius = alpha() * cell_size(grid.h_top, level);
    float weight = blend_weight(distance, radius, level, 1u, top_level());
    if (weight <= 0.0) {
        return;
    }
    float response = expected_response(light, place.position_ws, place.normal_ws);
    float f = weight * chosen_response(light, place, response) * luminance(light.flux);
    if (shadow_sample_count() == 0u || level < first_shadow_level()) {
        found.unshadowed += weight * response * light.flux;
    } else if (f > 0.0) {
        found.total += f;
        found.light = random(random_state) * found.total < f ? index : found.light;
    }
}

// What a lane's share of the lights sends to a place.
Found find_lights(PointPlace place, uint lane, inout uint random_state) {
    Found found = Found(vec3(0.0), 0.0, NO_LIGHT);
    for (uint level = 1u; level <= top_level(); ++level) {
        VertexRows rows = rows_in_reach(place.position_ws, level);
        uint count = row_count(rows);
        for (uint row = lane; row < count; row += POINT_LANES) {
            uvec2 range = ranks_of_row(rows, row);
            for (uint rank = range.x; rank < range.y; ++rank) {
                add_light(place, level_first(level) + rank, level, found, random_state);
            }
        }
    }
    return found;
}

// What the lights of a lane send to a place if nothing hides the one that was chosen: as much as they were chosen for, by what
// the light S0 that a ray is cast to sends there.
vec3 shadowed_radiance(Found found, PointPlace expected_at, PointPlace place, inout uint random_state) {
    GridLight chosen = grid_lights[found.light];
    uint original = original_below(found.light, chosen.level, random_state);
    Sender sender = Sender(chosen.position_ws, chosen.lobe, chosen.flux, chosen.level);
    if (original != NO_LIGHT) {
        sender = original_sender(original);
    }
    float response = sent_response(sender, place.position_ws, place.normal_ws);
    if (response <= 0.0 || is_light_blocked(place.position_ws, sender.position_ws, sender.lobe)) {
        return vec3(0.0);
    }
    float expected = expected_response(chosen, expected_at.position_ws, expected_at.normal_ws);
    float ratio = stand_in_ratio(response, chosen_response(chosen, expected_at, expected));
    return sender.flux * (ratio * found.total / max(luminance(sender.flux), 1e-30));
}

// Share of one lane of the irradiance from the hierarchy. Lights are looked up at the first place, rays start at all in turns.
vec3 hierarchy_irradiance(uint key, uint place_count, uint lane) {
    if (grid.light_count == 0u) {
        return vec3(0.0);
    }
    uint random_state = hash(key, lane, sampling_seed() ^ 0x3c6ef372u);
    Found found = find_lights(lit_places[0], lane, random_state);
    vec3 radiance = found.unshadowed;
    if (found.light != NO_LIGHT) {
        radiance += shadowed_radiance(found, lit_places[0], lit_places[lane % place_count], random_state);
    }
    return PI * radiance;
}
