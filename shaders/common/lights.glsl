// The lights of the hierarchy and their arithmetic. Needs frame.glsl, random.glsl (PI), color.glsl.

#include "shared/GridLight.glsl"

#include "shared/GridPlacement.glsl"

uint vertices_per_axis(uint level) { return frame.levels[level].x; }
uint words_per_row(uint level) { return frame.levels[level].y; }
uint first_word(uint level) { return frame.levels[level].z; }
uint end_word(uint level) { return frame.levels[level].w; }

// Edge of a cell of a level: h_top / 2^(Lmax - l). Exact, being a power of two; level 0 is half of level 1.
float cell_size(float h_top, uint level) { return ldexp(h_top, int(level) - int(top_level())); }

// A position in units of a level's cells, within the level's vertices. Precise, as lights are marked, counted and listed by
// cell in shaders of their own: one that contracted this to a fused multiply-add could find another cell than the rest.
vec3 grid_position(vec3 position_ws, GridPlacement grid, uint level) {
    precise vec3 cells = (position_ws - grid.origin_ws) * ldexp(grid.inverse_h_top, int(top_level()) - int(level));
    return clamp(cells, vec3(0.0), vec3(float(vertices_per_axis(level) - 1u)));
}

// The cell that holds a grid position: its lowest vertex.
uvec3 cell_of(vec3 cells, uint level) { return min(uvec3(cells), uvec3(vertices_per_axis(level) - 2u)); }

// Where vertex (x, y, z) of a level stands in the occupancy bits: word and bit.
uint occupancy_word(uvec3 vertex, uint level) {
    uint n = vertices_per_axis(level);
    return first_word(level) + (vertex.z * n + vertex.y) * words_per_row(level) + vertex.x / 32u;
}

// Index of a vertex within its level, x fastest.
uint vertex_index(uvec3 vertex, uint level) {
    uint n = vertices_per_axis(level);
    return (vertex.z * n + vertex.y) * n + vertex.x;
}

uvec3 vertex_from_index(uint index, uint level) {
    uint n = vertices_per_axis(level);
    return uvec3(index % n, (index / n) % n, index / (n * n));
}

// A vertex of S1 in units of the cells of a level, exact: the grids nest.
vec3 s1_vertex_in_cells(uvec3 vertex, uint level) { return ldexp(vec3(vertex), ivec3(1 - int(level))); }

// Trilinear weight of corner (0 or 1 per axis) for a position `fraction` inside its cell.
float trilinear_weight(vec3 fraction, uvec3 corner) {
    vec3 w = mix(1.0 - fraction, fraction, equal(corner, uvec3(1u)));
    return w.x * w.y * w.z;
}

// Blending function of a level at distance d (Yuksel and Yuksel 2017, Figure 2): the functions of all used
// levels sum to 1 at any distance.
float blend_weight(float d, float radius, uint level, uint first_used, uint last_used) {
    float rise = level == first_used ? 1.0 : clamp(2.0 * d / radius - 1.0, 0.0, 1.0);
    float fall = level == last_used ? 1.0 : clamp(2.0 - d / radius, 0.0, 1.0);
    return min(rise, fall);
}

// How a grid light sends out its flux, one of LOBE_*.
layout(constant_id = 1) const uint LOBE = LOBE_MIXTURE;

// Radiant intensity per unit flux towards the unit direction w, of a light whose mean normal is `lobe`.
float lobe_intensity(vec3 lobe, vec3 w, uint kind) {
    float agreement = min(length(lobe), 1.0);
    float along = dot(lobe, w);
    if (kind == LOBE_CLAMPED_NORMAL) {
        return max(along, 0.0) / PI;
    }
    if (kind == LOBE_SH1) {
        return max(0.25 + 0.5 * along, 0.0) / PI;
    }
    if (kind == LOBE_SH1_NONLINEAR) {
        // Sloan 2013 after Geomerics 2012: mean and first moment kept, never negative.
        float power = 1.0 + 2.0 * agreement;
        float base = (1.0 - agreement) / (1.0 + agreement);
        float q = 0.5 * (1.0 + along / max(agreement, 1e-6));
        return 0.25 * (base + (1.0 - base) * (power + 1.0) * pow(max(q, 0.0), power)) / PI;
    }
    // A clamped cosine about the mean normal for the part of the light that agrees on it, uniform for the rest: keeps
    // the flux whatever the lobe's length, and is exact for a single light.
    return ((1.0 - agreement) * 0.25 + max(along, 0.0)) / PI;
}

// Luminance of a merged light that is one of S0, before it was dealt: deal scales its weight, 1, as well.
float own_luminance(GridLight merged) { return merged.luminance / merged.weight; }

// Squared distance below which a light does not grow brighter. A VPL of much flux stands for a disc as much larger: where few
// paths start, VPLs are much brighter, and each would leave a glow around it. Lamps, which have no lobe, stand for no disc.
float clamp_squared_of(vec3 lobe, uint level, float own_luminance) {
    bool is_vpl = level == 0u && lobe != vec3(0.0);
    return is_vpl ? frame.clamp_squared * max(own_luminance / frame.large_vpl_luminance, 1.0) : frame.clamp_squared;
}

// Outgoing radiance per unit albedo and unit flux at a surface point; `offset` leads from it to the light of a level.
// The lights themselves, level 0, have the lobe that is exact for them; `own_luminance` of their flux is read for them alone.
float light_response(vec3 offset, float distance, vec3 normal, vec3 lobe, uint level, float own_luminance) {
    float clamped = max(distance * distance, clamp_squared_of(lobe, level, own_luminance));
    vec3 w = offset / max(distance, 1e-20);
    float cosine = max(dot(normal, w), 0.0);
    return cosine <= 0.0 ? 0.0 : lobe_intensity(lobe, -w, level == 0u ? LOBE_MIXTURE : LOBE) * cosine / clamped / PI;
}
