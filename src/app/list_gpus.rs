//! `--list-gpus`: the devices and what they can do.

use std::fmt::Write as _;

use super::say;
use crate::Result;
use crate::gpu::list_gpus;

/// Prints every device, with each optional feature found or missing.
///
/// # Errors
/// [`crate::Error::NoDevice`] without a Vulkan loader or driver.
pub fn list() -> Result<()> {
    let mut text = String::new();
    for (index, gpu) in list_gpus()?.iter().enumerate() {
        let _ = writeln!(text, "{index}: {} ({}, Vulkan {}, {})", gpu.name, gpu.kind, gpu.api_version, gpu.driver);
        let suitable =
            if gpu.missing.is_empty() { "yes".to_owned() } else { format!("no, lacks {}", gpu.missing.join(", ")) };
        let _ = writeln!(text, "   suitable: {suitable}");
        if gpu.is_portability_subset {
            let _ = writeln!(text, "   a portability subset of Vulkan: what it lacks is not used");
        }
        for (name, found, fallback) in gpu.optional.rows() {
            let state = if found { "found".to_owned() } else { format!("missing ({fallback})") };
            let _ = writeln!(text, "   {name}: {state}");
        }
        let limits = &gpu.limits;
        let _ = writeln!(
            text,
            "   limits: storage buffer {} MiB, {} of them per stage, image {} px, {} array layers, subgroup {}",
            limits.storage_range_bytes >> 20,
            limits.stage.storage_buffers,
            limits.image_edge_px,
            limits.array_layers,
            limits.subgroup_size
        );
    }
    say(&text)
}
