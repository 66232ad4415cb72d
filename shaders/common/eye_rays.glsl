// Rays from the eye and towards it, which go through the surfaces that the camera looks through (`--back-faces cull`). Needs
// frame.glsl and scene.glsl.

// Surfaces that one ray goes through at most; at the next it ends.
const uint MOST_LOOKED_THROUGH = 16u;

// Whether the camera looks through a surface that a ray from it, along `direction`, meets.
bool is_looked_through(Hit hit, vec3 direction) {
    BvhTriangle tri = bvh_triangle(hit.bvh_triangle);
    bool is_single_sided = (materials[tri.material].flags & MATERIAL_SINGLE_SIDED) != 0u;
    return frame.culls_back_faces != 0u && is_single_sided && dot(cross(tri.edge1, tri.edge2), direction) > 0.0;
}

// The nearest surface that the camera sees along a direction. Its distance is that from the last surface looked through.
bool traverse_from_eye(vec3 direction, out Hit hit) {
    vec3 origin = frame.eye_ws;
    for (uint i = 0u; traverse(origin, direction, 3e38, false, hit); ++i) {
        if (i == MOST_LOOKED_THROUGH || !is_looked_through(hit, direction)) {
            return true;
        }
        origin += direction * hit.t;
        origin += direction * ray_offset(origin);
    }
    return false;
}

// Whether a surface that the camera sees lies between a position and the eye, which is so far away in this direction.
bool is_hidden_from_eye(vec3 origin, vec3 direction, float distance) {
    if (frame.culls_back_faces == 0u) {
        return is_blocked(origin, direction, distance);
    }
    Hit hit;
    for (uint i = 0u; traverse(origin, direction, distance, false, hit); ++i) {
        if (i == MOST_LOOKED_THROUGH || !is_looked_through(hit, -direction)) {
            return true;
        }
        origin += direction * hit.t;
        float off = ray_offset(origin);
        origin += direction * off;
        distance -= hit.t + off;
    }
    return false;
}
