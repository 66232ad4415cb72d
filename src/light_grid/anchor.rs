//! Where the grids stand when their lights are others in every frame: a cube that does not follow the lights.

/// How far lights may lie outside, as a part of the edge, to count as on the face: those of outer walls by rounding, and those of
/// surfaces that go a little further between the moments that the scene's bounds were found at.
const SLACK: f32 = 1.0 / 1024.0;
/// Doublings at most; from any size on, all numbers are inside by then.
const MOST_DOUBLINGS: u32 = 256;

/// The cube that the top level's cell is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridAnchor {
    /// Its lowest corner.
    pub low_ws: [f32; 3],
    /// Its edge, in metres.
    pub edge: f32,
}

impl GridAnchor {
    /// The cube around a scene's bounds at all times; none around a scene without an extent. Its low faces are those of the bounds:
    /// where they are walls, the lights there have vertices of their own.
    #[must_use]
    pub fn around(low_ws: [f32; 3], high_ws: [f32; 3]) -> Option<Self> {
        let edge = (0..3).map(|axis| high_ws[axis] - low_ws[axis]).fold(0.0, f32::max) * 1.0001;
        (edge > 0.0 && edge.is_finite()).then_some(Self { low_ws, edge })
    }

    /// The cube doubled until lights with these bounds are inside, in the directions in which they lie: vertices of a level become
    /// vertices of the level below. Twin of the loop in `bounds/place_grid`.
    #[must_use]
    pub fn grown(mut self, low_ws: [f32; 3], high_ws: [f32; 3]) -> Self {
        for _ in 0..MOST_DOUBLINGS {
            let slack = self.edge * SLACK;
            let below = [0, 1, 2].map(|axis| low_ws[axis] < self.low_ws[axis] - slack);
            let above = (0..3).any(|axis| high_ws[axis] > self.low_ws[axis] + self.edge + slack);
            if !above && !below.contains(&true) {
                break;
            }
            for axis in (0..3).filter(|axis| below[*axis]) {
                self.low_ws[axis] -= self.edge;
            }
            self.edge *= 2.0;
        }
        self
    }

    /// As the shader `bounds/place_grid` takes it: edge and corner, zeros where the grids follow the lights.
    #[must_use]
    pub fn words(anchor: Option<Self>) -> Vec<u32> {
        let [x, y, z] = anchor.map_or([0.0; 3], |anchor| anchor.low_ws);
        [anchor.map_or(0.0, |anchor| anchor.edge), x, y, z].map(f32::to_bits).to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_encloses_a_scene_and_a_point_has_none() {
        let anchor = GridAnchor::around([0.0, -1.0, 0.0], [128.0, 1.0, 2.0]).unwrap();
        assert_eq!(anchor, GridAnchor { low_ws: [0.0, -1.0, 0.0], edge: 128.0 * 1.0001 });
        assert_eq!(GridAnchor::around([1.0; 3], [1.0; 3]), None);
    }

    #[test]
    fn it_grows_only_for_lights_outside_and_towards_them() {
        let anchor = GridAnchor { low_ws: [0.0; 3], edge: 4.0 };
        assert_eq!(anchor.grown([-0.003; 3], [4.003; 3]), anchor);
        assert_eq!(anchor.grown([0.0; 3], [4.005, 4.0, 4.0]), GridAnchor { low_ws: [0.0; 3], edge: 8.0 });
        assert_eq!(anchor.grown([-1.0, 1.0, 1.0], [2.0; 3]), GridAnchor { low_ws: [-4.0, 0.0, 0.0], edge: 8.0 });
        assert_eq!(anchor.grown([1.0; 3], [1.0, 17.0, 1.0]), GridAnchor { low_ws: [0.0; 3], edge: 32.0 });
        // What no doubling reaches ends as well.
        assert!(anchor.grown([f32::MIN; 3], [f32::MAX; 3]).edge > 0.0);
    }
}
