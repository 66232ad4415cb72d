// The environment: what comes from far away in every direction, and directions drawn by how much comes from them. Needs
// frame.glsl, random.glsl, scene.glsl. Rust: environment::SamplingTable.
#include "common/search.glsl"

// Equirectangular, its first row towards +y; times frame.environment_scale it is radiance.
layout(set = 1, binding = 9) uniform texture2D environment_map;
// Cells of the image's area, frame.environment_cells of them: for each row of cells the probability of those above it,
// and 1; then for each row, for each of its cells the probability of those before it in the row, and 1.
layout(set = 1, binding = 10, std430) readonly buffer EnvironmentTable { float environment_table[]; };

bool has_environment() { return frame.environment_cells.x > 0u; }

// Where a direction lies in the image, both 0 to 1, v from the top. The pole is at any u.
vec2 environment_place(vec3 direction) {
    vec2 level = direction.xz;
    float across = length(level);
    float azimuth = across > 0.0 ? atan(level.y, level.x) : 0.0;
    // As of a unit vector; exact near the poles, where acos is not.
    float polar = atan(across, direction.y);
    return vec2(fract(azimuth / (2.0 * PI) + 0.5 + frame.environment_turn), clamp(polar / PI, 0.0, 1.0));
}

// Direction at a u of the image and a cosine of the angle from +y.
vec3 environment_direction(float u, float polar_cosine) {
    float azimuth = 2.0 * PI * (u - frame.environment_turn - 0.5);
    float across = sqrt(max(1.0 - polar_cosine * polar_cosine, 0.0));
    return vec3(across * cos(azimuth), polar_cosine, across * sin(azimuth));
}

// Radiance from a direction: bilinear, around in u and up to the poles in v. By hand, as not every device filters floats.
vec3 environment_radiance(vec3 direction) {
    ivec2 size = textureSize(environment_map, 0);
    vec2 at = environment_place(direction) * vec2(size) - 0.5;
    vec2 part = fract(at);
    ivec2 low = ivec2(floor(at));
    ivec2 left_top = ivec2((low.x + size.x) % size.x, max(low.y, 0));
    ivec2 right_bottom = ivec2((low.x + 1) % size.x, min(low.y + 1, size.y - 1));
    vec3 top = mix(
        texelFetch(environment_map, left_top, 0).rgb,
        texelFetch(environment_map, ivec2(right_bottom.x, left_top.y), 0).rgb, part.x);
    vec3 bottom = mix(
        texelFetch(environment_map, ivec2(left_top.x, right_bottom.y), 0).rgb,
        texelFetch(environment_map, right_bottom, 0).rgb, part.x);
    return frame.environment_scale * mix(top, bottom, part.y);
}

float environment_sum(uint i) { return environment_table[i]; }

DEFINE_INTERVAL_SEARCH(environment_interval, environment_sum)

// A cell of the table: where its intervals begin, along its row and down the rows, and their lengths, which are
// probabilities.
struct EnvironmentCell {
    uvec2 cell;
    vec2 first;
    vec2 share;
};

uint first_of_row(uint row) { return frame.environment_cells.y + 1u + row * (frame.environment_cells.x + 1u); }

EnvironmentCell environment_cell(uvec2 cell) {
    uint column = first_of_row(cell.y) + cell.x;
    vec2 first = vec2(environment_table[column], environment_table[cell.y]);
    vec2 end = vec2(environment_table[column + 1u], environment_table[cell.y + 1u]);
    return EnvironmentCell(cell, first, end - first);
}

// Cosines of the angles from +y of a row's upper and lower edge.
vec2 row_cosines(uint row) {
    vec2 edges = vec2(row, row + 1u) / float(frame.environment_cells.y);
    return cos(PI * edges);
}

// Probability per steradian of directions in a cell, all of which are equally likely.
float cell_density(EnvironmentCell cell) {
    vec2 cosines = row_cosines(cell.cell.y);
    float solid_angle = 2.0 * PI / float(frame.environment_cells.x) * (cosines.x - cosines.y);
    return cell.share.x * cell.share.y / max(solid_angle, 1e-20);
}

struct EnvironmentSample {
    vec3 direction;
    // Per steradian.
    float density;
};

// The direction of two numbers between 0 and 1: as many directions as there is light.
EnvironmentSample sample_environment(vec2 u) {
    uvec2 count = frame.environment_cells;
    uint row = environment_interval(0u, count.y, u.y);
    uint column = environment_interval(first_of_row(row), count.x, u.x);
    EnvironmentCell cell = environment_cell(uvec2(column, row));
    vec2 inside = clamp((u - cell.first) / max(cell.share, vec2(1e-20)), 0.0, 1.0);
    vec2 cosines = row_cosines(row);
    float polar_cosine = mix(cosines.x, cosines.y, inside.y);
    vec3 direction = environment_direction((float(column) + inside.x) / float(count.x), polar_cosine);
    return EnvironmentSample(direction, cell_density(cell));
}

// The cell that a direction lies in.
EnvironmentCell environment_cell_of(vec3 direction) {
    uvec2 count = frame.environment_cells;
    return environment_cell(min(uvec2(environment_place(direction) * vec2(count)), count - 1u));
}

// The density with which `sample_environment` draws a direction, per steradian.
float environment_density(vec3 direction) {
    return cell_density(environment_cell_of(direction));
}

// A direction drawn by the environment's light, or by the cosine to a surface; half of them are to be of either kind.
vec3 mixed_direction(vec3 normal, vec2 u, bool by_light) {
    return by_light ? sample_environment(u).direction : cosine_direction(normal, u);
}

// The density of directions of both kinds together, per steradian, where the cosine is above 0.
float mixed_density(vec3 direction, float cosine) {
    return 0.5 * (environment_density(direction) + cosine / PI);
}

// The two numbers that `sample_environment` takes to a direction.
vec2 environment_numbers(vec3 direction) {
    EnvironmentCell cell = environment_cell_of(direction);
    vec2 cosines = row_cosines(cell.cell.y);
    float down = (cosines.x - direction.y) / max(cosines.x - cosines.y, 1e-20);
    float along = fract(environment_place(direction).x * float(frame.environment_cells.x));
    return clamp(cell.first + cell.share * clamp(vec2(along, down), 0.0, 1.0), 0.0, 1.0);
}

// Whether a ray leaves the scene.
bool is_open(vec3 origin, vec3 direction) {
    return !is_blocked(origin, direction, 3e38);
}
