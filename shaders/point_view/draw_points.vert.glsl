// A disc for each point that is shown: on its surface as the camera sees it, or level, as seen from above. Six vertices per
// instance.
#include "common/frame.glsl"
#include "shared/ShownPoint.glsl"

layout(set = 0, binding = 1, std430) readonly buffer ShownPoints { ShownPoint shown_points[]; };
layout(set = 0, binding = 2, std430) readonly buffer ShownBounds { uint shown_bounds[4]; };
#include "point_view/from_above.glsl"
layout(constant_id = 0) const uint FROM_ABOVE = 0u;

layout(location = 0) out vec2 out_corner;
layout(location = 1) flat out uint out_number_and_key;

// A disc lies on its surface: nearer to the eye by a part of its radius it is not lost to rounding or to a curved one.
const float LIFT = 0.5;
// Smallest radius in the picture.
const float LEAST_PX = 0.75;

// Clip position of a corner on a disc that the camera sees.
vec4 seen_corner(ShownPoint point, vec2 corner) {
    vec3 axis = abs(point.normal.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0);
    vec3 tangent = normalize(cross(axis, point.normal));
    vec3 bitangent = cross(point.normal, tangent);
    vec3 offset = point.position_ws - frame.eye_ws;
    float pixel = 2.0 * length(frame.up_ws) * dot(offset, frame.forward_ws) / float(frame.size_px.y);
    float radius = max(point.radius, LEAST_PX * pixel);
    vec4 clip = clip_position(point.position_ws + radius * (corner.x * tangent + corner.y * bitangent));
    // Reversed depth is near / view z.
    clip.z *= 1.0 + LIFT * point.radius / max(length(offset), 1e-20);
    return clip;
}

// The same seen from above; higher is nearer.
vec4 corner_from_above(ShownPoint point, vec2 corner) {
    float pixels_at_1 = pixels_at_1_from_above();
    vec2 pixel = pixel_from_above(point.position_ws) + max(point.radius * pixels_at_1, LEAST_PX) * corner;
    float height = (point.position_ws.y - frame.scene_center_ws.y) / max(frame.scene_radius, 1e-20);
    return vec4(pixel / vec2(frame.size_px) * 2.0 - 1.0, clamp(0.5 + 0.5 * height, 0.0, 1.0), 1.0);
}

void main() {
    const vec2 CORNERS[6] = vec2[](
        vec2(-1.0, -1.0), vec2(1.0, -1.0), vec2(1.0, 1.0), vec2(-1.0, -1.0), vec2(1.0, 1.0), vec2(-1.0, 1.0));
    ShownPoint point = shown_points[gl_InstanceIndex];
    out_corner = CORNERS[gl_VertexIndex];
    out_number_and_key = point.number_and_key;
    gl_Position = FROM_ABOVE != 0u ? corner_from_above(point, out_corner) : seen_corner(point, out_corner);
}
