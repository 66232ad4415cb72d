// Pixels of the half picture. Rust: half_picture::halved.
uvec2 half_size() { return (image_size() + 1u) / 2u; }
