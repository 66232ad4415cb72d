// A material as shaders read it. Rust: shared::GpuMaterial.
struct Material {
    vec4 base_color;
    uint albedo_layer;
    float alpha_cutoff;
    float normal_scale;
    uint has_normal_map;
};
