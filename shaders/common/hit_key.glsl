// From a ray's hit to a side of a leaf. Needs scene.glsl, points.glsl, point_hits.glsl.

// The side of a leaf that a ray in this direction has hit.
uint hit_key(Hit hit, vec3 direction) {
    BvhTriangle tri = bvh_triangle(hit.bvh_triangle);
    uint leaf = frame.point_leaf_count + leaf_of_hit(tri.triangle_index, hit.barycentric);
    vec3 geometric = cross(tri.edge1, tri.edge2);
    // A leaf of another triangle stands for this one where it has none of its own, and may face the other way.
    bool leaf_faces = dot(geometric, direction) * dot(geometric, point_node(leaf).normal) < 0.0;
    return 2u * leaf + (leaf_faces ? 0u : 1u);
}
