// A cube of half-size 2 r_l around every light below the top level of one sub-image. 36 vertices per instance.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/lights.glsl"

layout(set = 0, binding = 1, std430) readonly buffer MergedLights { GridLight merged_lights[]; };
layout(set = 0, binding = 2, std430) readonly buffer Tiles { uint tiles[]; };
layout(set = 0, binding = 3, std430) readonly buffer Grid { GridPlacement grid; };
layout(push_constant) uniform Push { uint tile; };

#include "merge/tiles.glsl"

layout(location = 0) flat out uint out_light;
layout(location = 1) flat out float out_radius;

// Corner of the unit cube [-1, 1]^3: six faces of two triangles, counter-clockwise seen from outside.
vec3 cube_corner(uint vertex) {
    const uvec2 QUAD[6] = uvec2[](uvec2(0, 0), uvec2(1, 0), uvec2(1, 1), uvec2(0, 0), uvec2(1, 1), uvec2(0, 1));
    uint face = vertex / 6u;
    uint axis = face % 3u;
    bool negative = face >= 3u;
    vec2 uv = vec2(QUAD[vertex % 6u]) * 2.0 - 1.0;
    uv = negative ? uv.yx : uv;
    vec3 corner;
    corner[axis] = negative ? -1.0 : 1.0;
    corner[(axis + 1u) % 3u] = uv.x;
    corner[(axis + 2u) % 3u] = uv.y;
    return corner;
}

void main() {
    uint light = tiles[TILE_STRIDE * tile + first_level()] + gl_InstanceIndex;
    float radius = alpha() * cell_size(grid.h_top, merged_lights[light].level);
    vec3 position_ws = merged_lights[light].position_ws + cube_corner(gl_VertexIndex) * (2.0 * radius);
    out_light = light;
    out_radius = radius;
    gl_Position = frame.clip_from_world * vec4(position_ws, 1.0);
}
