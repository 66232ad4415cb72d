// Where a camera sees something: in pixels from the upper left corner of the picture, y down, and its distance along the
// viewing direction. Where in their area pixels are sampled does not matter. Needs frame.glsl.
vec3 seen_at(vec3 from_eye, vec3 forward, vec3 right, vec3 up) {
    // Precise, so that equal inputs give equal results wherever it is called.
    precise float ahead = dot(from_eye, forward);
    precise vec2 ndc = vec2(dot(from_eye, right) / dot(right, right), -dot(from_eye, up) / dot(up, up)) / ahead;
    precise vec2 at = (ndc * 0.5 + 0.5) * vec2(image_size());
    return vec3(at, ahead);
}

vec3 seen_now(vec3 from_eye) { return seen_at(from_eye, frame.forward_ws, frame.right_ws, frame.up_ws); }

// The same with the camera of the frame before.
vec3 seen_before(vec3 from_eye) {
    return seen_at(from_eye, frame.previous_forward_ws, frame.previous_right_ws, frame.previous_up_ws);
}
