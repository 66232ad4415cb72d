// A volume around the sphere of radius 2 r_l of every light below the top level of one sub-image. LIGHT_VOLUME_VERTICES
// vertices per instance.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/lights.glsl"

layout(set = 0, binding = 1, std430) readonly buffer MergedLights { GridLight merged_lights[]; };
layout(set = 0, binding = 2, std430) readonly buffer SubImages { uint sub_images[]; };
layout(set = 0, binding = 3, std430) readonly buffer Grid { GridPlacement grid; };
layout(push_constant) uniform Push { uint sub_image; };

#include "merge/sub_images.glsl"

layout(location = 0) flat out uint out_light;
layout(location = 1) flat out float out_radius;

const float GOLDEN = 1.6180340;

// Corner of the icosahedron around the unit sphere: it covers 1.2 times the sphere's volume, where a cube covers 1.9 times.
// 20 triangles, counter-clockwise seen from outside.
vec3 corner(uint vertex) {
    const uvec3 FACES[20] = uvec3[](
        uvec3(0, 8, 2), uvec3(0, 2, 9), uvec3(0, 6, 4), uvec3(0, 4, 8), uvec3(0, 9, 6),
        uvec3(1, 3, 10), uvec3(1, 11, 3), uvec3(1, 4, 6), uvec3(1, 10, 4), uvec3(1, 6, 11),
        uvec3(2, 5, 7), uvec3(2, 8, 5), uvec3(2, 7, 9), uvec3(3, 7, 5), uvec3(3, 5, 10),
        uvec3(3, 11, 7), uvec3(4, 10, 8), uvec3(5, 8, 10), uvec3(6, 9, 11), uvec3(7, 11, 9));
    uint index = FACES[vertex / 3u][vertex % 3u];
    float s = (index & 2u) == 0u ? -1.0 : 1.0;
    float t = (index & 1u) == 0u ? -GOLDEN : GOLDEN;
    vec3 position = index < 4u ? vec3(0.0, s, t) : index < 8u ? vec3(s, t, 0.0) : vec3(t, 0.0, s);
    // Over the radius of the sphere inside, and a hair.
    return position * (1.0001 * sqrt(3.0) / (GOLDEN * GOLDEN));
}

void main() {
    uint light = sub_images[SUB_IMAGE_STRIDE * sub_image + first_level()] + gl_InstanceIndex;
    float radius = alpha() * cell_size(grid.h_top, merged_lights[light].level);
    vec3 position_ws = merged_lights[light].position_ws + corner(gl_VertexIndex) * (2.0 * radius);
    out_light = light;
    out_radius = radius;
    gl_Position = clip_position(position_ws);
}
