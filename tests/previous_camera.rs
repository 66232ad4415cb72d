//! What a frame's constants tell of the frame before it.

mod common;

use common::rooms::furnished_room;
use gridlight::renderer::{Fresh, Job, Renderer, UploadedScene};
use gridlight::settings::{Settings, Size, Technique};

#[test]
fn a_frame_knows_the_camera_of_the_frame_before_unless_there_was_a_cut() {
    let test = common::gpu();
    let scene = furnished_room();
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    // Every frame of a mean is sampled elsewhere, so that its matrix is another.
    let settings = Settings::default().changed(|s| {
        s.picture.size = Size { width: 16, height: 9 };
        s.render.technique = Technique::Direct;
        s.render.accumulate = 4;
    });
    let mut renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], &settings)).unwrap();
    let mut matrices = Vec::new();
    for (number, valid) in [(0, false), (1, true), (2, true), (3, false)] {
        if number == 3 {
            renderer.cut();
        }
        renderer.set_accumulated_frame(number, Fresh::All);
        let ticket = renderer.submit().unwrap();
        renderer.wait(ticket).unwrap();
        let data = renderer.frame_data();
        matrices.push(data.clip_from_world);
        let before = if valid { matrices[number as usize - 1] } else { data.clip_from_world };
        assert_eq!(data.history_is_valid, u32::from(valid), "frame {number}");
        assert_eq!((data.previous_clip_from_world, data.previous_eye_ws), (before, data.eye_ws), "frame {number}");
    }
    assert!(matrices.windows(2).all(|pair| pair[0] != pair[1]), "the frames differ in their matrices");
}
