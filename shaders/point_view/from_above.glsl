// The picture from above: the points and the camera fill it, -z is at the top. Needs frame.glsl, and the buffer `shown_bounds`
// for the functions of the picture.

// Around the points, over the edge of the picture.
const float MARGIN = 0.06;

// Numbers in the order of floats, as whole ones, and back.
uint ordered_from_float(float value) {
    uint bits = floatBitsToUint(value);
    return (bits >> 31u) != 0u ? ~bits : bits | 0x80000000u;
}

float float_from_ordered(uint ordered) {
    return uintBitsToFloat((ordered >> 31u) != 0u ? ordered & 0x7fffffffu : ~ordered);
}

#ifndef WRITES_BOUNDS
// Highest and lowest place of any point and of the eye, in x and z.
vec2 highest_place() {
    vec2 points = vec2(float_from_ordered(shown_bounds[0]), float_from_ordered(shown_bounds[1]));
    return shown_bounds[0] == 0u ? frame.eye_ws.xz : max(points, frame.eye_ws.xz);
}

vec2 lowest_place() {
    vec2 points = -vec2(float_from_ordered(shown_bounds[2]), float_from_ordered(shown_bounds[3]));
    return shown_bounds[0] == 0u ? frame.eye_ws.xz : min(points, frame.eye_ws.xz);
}

// Pixels of a unit of length.
float pixels_at_1_from_above() {
    vec2 extent = max(highest_place() - lowest_place(), vec2(1e-6 * frame.scene_radius + 1e-20));
    vec2 fitting = (1.0 - 2.0 * MARGIN) * vec2(frame.size_px) / extent;
    return min(fitting.x, fitting.y);
}

vec2 pixel_from_above(vec3 position_ws) {
    vec2 offset = position_ws.xz - 0.5 * (highest_place() + lowest_place());
    return 0.5 * vec2(frame.size_px) + pixels_at_1_from_above() * offset;
}
#endif
