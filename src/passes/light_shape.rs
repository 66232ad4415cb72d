//! What sizes the passes that trace virtual point lights and shade with them.

use std::sync::Arc;

use crate::light_paths::StartDensity;

/// How many light paths and lights there are.
#[derive(Clone, Debug, PartialEq)]
pub struct LightShape {
    /// Light paths.
    pub path_count: u32,
    /// Where they start; `None` is as many everywhere.
    pub starts: Option<Arc<StartDensity>>,
    /// Whether the VPLs asked for would take more paths than are traced, as most hit nothing.
    pub lacks_paths: bool,
    /// Most VPLs per path.
    pub bounces: u32,
    /// VPLs that fit into S0.
    pub vpl_capacity: u32,
    /// Lights of the scene in S0.
    pub scene_light_count: u32,
    /// Shadow rays per pixel; 0 is no shadows of indirect light.
    pub shadow_samples: u32,
    /// Radius of the disc that a VPL stands for, in metres; 0 where there are none.
    pub vpl_radius: f32,
    /// Flux that half of the VPLs exceed, as a share of what all lights emit (luminances); 0 where there are none.
    pub vpl_flux_share: f32,
}

impl LightShape {
    /// Lights that fit into S0.
    #[must_use]
    pub fn light_capacity(&self) -> u32 {
        (self.vpl_capacity + self.scene_light_count).max(1)
    }

    /// Slots that light paths write VPLs to.
    #[must_use]
    pub fn slot_count(&self) -> u32 {
        (self.path_count * self.bounces).max(1)
    }
}
