// Reading the G-buffer. Needs frame.glsl and octahedral.glsl; the including shader declares the textures.

// From the eye to where the pixel was sampled, at distance 1 along the viewing direction.
vec3 view_ray(uvec2 pixel) {
    vec2 ndc = (vec2(pixel) + 0.5 + pixel_jitter()) / vec2(image_size()) * 2.0 - 1.0;
    return ray_through(ndc);
}

// World position from reversed-Z depth (near / view z) where the pixel was sampled.
vec3 position_from_depth(uvec2 pixel, float depth) {
    return frame.eye_ws + view_ray(pixel) * (frame.near / depth);
}

// Rays from a rasterised surface start this far off it: its depth is that of triangles whose corners were moved
// to subpixel positions (SwiftShader has 16 per pixel and axis, which shows as false shadow).
float surface_offset(vec3 position_ws) {
    return ray_offset(position_ws) + frame.rasteriser_step * dot(position_ws - frame.eye_ws, frame.forward_ws);
}
