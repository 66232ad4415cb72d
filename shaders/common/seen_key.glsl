// From a leaf that is hit to the node that is kept of it. Needs points.glsl and random.glsl.

// The key that one side of a leaf is kept as: of the largest node above it that subtends no more than a texel of this solid
// angle, or is no larger than the receiver.
uint seen_key(uint key, vec3 position, float solid_angle, float receiver_radius) {
    while (key >= 4u) {
        PointNode parent = point_node(key >> 2u);
        vec3 offset = parent.centroid_ws - position;
        float subtended = PI * parent.radius * parent.radius;
        bool is_small = subtended <= frame.hit_texels * solid_angle * dot(offset, offset);
        if (!(is_small || parent.radius <= receiver_radius) || parent.cone_cos < frame.hit_cone_cos) {
            break;
        }
        key = parent_key(key);
    }
    return key;
}
