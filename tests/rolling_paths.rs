//! Light paths of which every frame renews some (`--vpl-seeds rolling`).

mod common;

use common::gpu;
use common::rooms::courtyard;
use common::written::Written;
use gridlight::renderer::{FRAMES_OF_PATHS, Fresh, Job, Renderer, UploadedScene};
use gridlight::settings::{Settings, Size, Technique};

const BOUNCES: u32 = 2;

/// What the paths of a frame leave.
struct Paths {
    /// Where each path first hit a surface, and the normal; 0 where it hit none.
    first_hits: Vec<[u32; 4]>,
    /// Green of all VPLs' fluxes.
    flux: f64,
}

/// Frames with these numbers, one after the other.
fn paths(fresh: Fresh, vpls: u32, numbers: impl IntoIterator<Item = u32>) -> Vec<Paths> {
    let test = gpu();
    let scene = courtyard();
    let settings = Settings::default().changed(|s| {
        // Pixels are not looked at, and each would be lit by every light.
        s.picture.size = Size { width: 2, height: 1 };
        (s.many_lights.vpls, s.many_lights.bounces) = (vpls, BOUNCES);
        s.render.technique = Technique::BruteForce;
    });
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    let mut renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], &settings)).unwrap();
    let frame = |number: u32| {
        renderer.set_accumulated_frame(number, fresh);
        let written = Written::by(&renderer);
        let [positions, fluxes]: [Vec<[u32; 4]>; 2] =
            ["vpl_slot_positions", "vpl_slot_fluxes"].map(|name| written.all("vpl_trace", name));
        let bits: Vec<u32> = written.all("vpl_trace", "vpl_slot_bits");
        let is_set = |slot: usize| bits[slot / 32] >> (slot % 32) & 1 == 1;
        let count = renderer.frame_data().path_count as usize;
        let slots = (0..count).map(|path| path * BOUNCES as usize);
        Paths {
            first_hits: slots.map(|slot| if is_set(slot) { positions[slot] } else { [0; 4] }).collect(),
            flux: (0..count * BOUNCES as usize)
                .filter(|slot| is_set(*slot))
                .map(|slot| f64::from(f32::from_bits(fluxes[slot][1])))
                .sum(),
        }
    };
    numbers.into_iter().map(frame).collect()
}

#[test]
fn every_frame_renews_the_next_sixteenth() {
    // Numbers of paths that sixteen divides and does not.
    for vpls in [1, 300] {
        let frames = paths(Fresh::SomePaths, vpls, 0..FRAMES_OF_PATHS + 2);
        let count = frames[0].first_hits.len();
        let renewed_count = count.div_ceil(FRAMES_OF_PATHS as usize);
        for (number, pair) in frames.windows(2).enumerate() {
            let first = number * renewed_count % count;
            let mut others = 0;
            for path in 0..count {
                let is_renewed = (path + count - first) % count < renewed_count;
                let differs = pair[0].first_hits[path] != pair[1].first_hits[path];
                assert!(is_renewed || !differs, "{count} paths, frame {number}: path {path} is another");
                others += usize::from(differs);
            }
            // Some hit nothing twice.
            assert!(2 * others >= renewed_count || count < 16, "frame {number}: {others} of {renewed_count} differ");
        }
    }
}

#[test]
fn paths_follow_from_the_number_of_the_frame_and_carry_the_same_flux() {
    let all = paths(Fresh::SomePaths, 1000, 30..38);
    let alone = paths(Fresh::SomePaths, 1000, [37]);
    assert_eq!(all[7].first_hits, alone[0].first_hits);
    // Frames with no path in common, of some 10,000 paths each: the standard deviation of their mean is 0.3 %.
    let mean = |fresh: Fresh| {
        let frames = paths(fresh, 20_000, (0..8).map(|set| set * FRAMES_OF_PATHS));
        frames.iter().map(|paths| paths.flux).sum::<f64>() / frames.len() as f64
    };
    let [rolling, fresh] = [Fresh::SomePaths, Fresh::All].map(mean);
    assert!((rolling / fresh - 1.0).abs() <= 0.015, "{rolling} over {fresh}");
}
