// The interface of bvh.glsl by ray queries over the device's acceleration structures (gpu::acceleration).
#extension GL_EXT_ray_query : require

layout(set = 1, binding = 7) uniform accelerationStructureEXT scene_structure;
// The number of opaque triangles, then for each triangle of the structure its place in `bvh_triangles`, opaque ones
// first.
layout(set = 1, binding = 8, std430) readonly buffer QueryTriangles { uint query_triangles[]; };

// Which of `bvh_triangles` a triangle of the structure is. The opaque ones are geometry 0 where there are any.
uint queried_triangle(uint geometry, uint primitive) {
    return query_triangles[1u + geometry * query_triangles[0] + primitive];
}

// Nearest hit, or the first hit of any kind when `any_hit`. Cut-out texels are holes. Returns false on a miss.
bool traverse(vec3 origin, vec3 direction, float t_max, bool any_hit, out Hit hit) {
    rayQueryEXT query;
    uint flags = any_hit ? gl_RayFlagsTerminateOnFirstHitEXT : gl_RayFlagsNoneEXT;
    hit = Hit(t_max, vec2(0.0), 0u);
    // A sender nearer than the ray's ends are long leaves no ray, and a query must not have a negative range, nor NaN.
    if (t_max <= 0.0 || !is_finite_ray(origin, direction, t_max)) {
        return false;
    }
    rayQueryInitializeEXT(query, scene_structure, flags, 0xffu, origin, 0.0, direction, t_max);
    // Only alpha-masked triangles are left to the shader.
    while (rayQueryProceedEXT(query)) {
        uint candidate = queried_triangle(
            uint(rayQueryGetIntersectionGeometryIndexEXT(query, false)),
            uint(rayQueryGetIntersectionPrimitiveIndexEXT(query, false)));
        vec2 barycentric = rayQueryGetIntersectionBarycentricsEXT(query, false);
        if (!is_hole(Hit(0.0, barycentric, candidate))) {
            rayQueryConfirmIntersectionEXT(query);
        }
    }
    if (rayQueryGetIntersectionTypeEXT(query, true) != gl_RayQueryCommittedIntersectionTriangleEXT) {
        return false;
    }
    hit.t = rayQueryGetIntersectionTEXT(query, true);
    hit.barycentric = rayQueryGetIntersectionBarycentricsEXT(query, true);
    hit.bvh_triangle = queried_triangle(
        uint(rayQueryGetIntersectionGeometryIndexEXT(query, true)),
        uint(rayQueryGetIntersectionPrimitiveIndexEXT(query, true)));
    return true;
}
