//! How textures are read between and beyond their texels.

use crate::shared::{MATERIAL_NEAREST, MATERIAL_WRAP_SHIFT, WRAP_CLAMP, WRAP_MIRROR, WRAP_REPEAT};

/// What a texture is beyond its edges, along one axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Wrap {
    /// The same again.
    #[default]
    Repeat,
    /// The same again, every other time mirrored.
    Mirror,
    /// The texels at the edge.
    Clamp,
}

/// What is between two texels or two mips.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Filter {
    /// A mixture of both.
    #[default]
    Linear,
    /// The nearer one.
    Nearest,
}

/// A glTF sampler.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Sampling {
    /// Along u and v.
    pub wrap: [Wrap; 2],
    /// Where texels are larger than pixels, and for rays.
    pub magnify: Filter,
    /// Where texels are smaller than pixels.
    pub minify: Filter,
    /// Between mips, if there are to be any.
    pub mips: Option<Filter>,
}

impl Default for Sampling {
    fn default() -> Self {
        let linear = Filter::Linear;
        Self { wrap: [Wrap::Repeat; 2], magnify: linear, minify: linear, mips: Some(linear) }
    }
}

impl Wrap {
    /// The texel that texel `i` of `size` is.
    #[must_use]
    pub fn texel(self, i: i64, size: u32) -> u32 {
        let size = i64::from(size.max(1));
        let texel = match self {
            Self::Repeat => i.rem_euclid(size),
            Self::Mirror => {
                let place = i.rem_euclid(2 * size);
                place.min(2 * size - 1 - place)
            }
            Self::Clamp => i.clamp(0, size - 1),
        };
        texel as u32
    }

    fn bits(self) -> u32 {
        match self {
            Self::Repeat => WRAP_REPEAT,
            Self::Mirror => WRAP_MIRROR,
            Self::Clamp => WRAP_CLAMP,
        }
    }
}

impl Sampling {
    /// Its bits of a material's flags.
    #[must_use]
    pub fn flags(self) -> u32 {
        let nearest = if self.magnify == Filter::Nearest { MATERIAL_NEAREST } else { 0 };
        let [u, v] = self.wrap.map(Wrap::bits);
        nearest | u << MATERIAL_WRAP_SHIFT | v << (MATERIAL_WRAP_SHIFT + 2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_beyond_the_edges() {
        let row = |wrap: Wrap| (-4..7).map(|i| wrap.texel(i, 3)).collect::<Vec<_>>();
        assert_eq!(row(Wrap::Repeat), [2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0]);
        assert_eq!(row(Wrap::Mirror), [2, 2, 1, 0, 0, 1, 2, 2, 1, 0, 0]);
        assert_eq!(row(Wrap::Clamp), [0, 0, 0, 0, 0, 1, 2, 2, 2, 2, 2]);
    }
}
