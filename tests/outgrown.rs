//! A frame whose lights outgrow what was measured for them, as when the sun has turned: shadow rays lose the way down to
//! the lights S0, and end on the chosen light instead.

mod common;

use common::rooms::furnished_room;
use gridlight::passes::lgh_shape::LghShape;
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::settings::{Settings, Size};

#[test]
fn shadow_rays_need_no_table_of_every_light() {
    let test = common::gpu();
    let scene = furnished_room();
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    let settings = Settings::default().changed(|s| {
        s.picture.size = Size { width: 64, height: 48 };
        s.many_lights.vpls = 4000;
    });
    let job = Job::new(&test.gpu, &uploaded, &scene.cameras[0], &settings);
    let mut shapes = Renderer::new(&job).unwrap().shapes().clone();
    let measured = shapes.of_mut::<LghShape>().unwrap().upper_capacity;
    let mut luminance = |upper_capacity: u32| {
        shapes.of_mut::<LghShape>().unwrap().upper_capacity = upper_capacity;
        let mut renderer = Renderer::with_shapes(&job, shapes.clone()).unwrap();
        let ticket = renderer.submit().unwrap();
        renderer.wait(ticket).unwrap();
        let radiance = renderer.read_radiance().unwrap();
        assert!(radiance.iter().all(|value| value.is_finite() && *value >= 0.0), "{upper_capacity}");
        radiance.iter().map(|value| f64::from(*value)).sum::<f64>() / radiance.len() as f64
    };
    let whole = luminance(measured);
    for upper_capacity in [0, 1, 8] {
        let ratio = luminance(upper_capacity) / whole;
        println!("{upper_capacity} tables: {ratio:.4} of the light");
        // Ends jittered about a light lie inside walls more often than the lights S0 do.
        assert!((ratio - 1.0).abs() <= 0.25, "{upper_capacity} tables: {ratio} of the light");
    }
    assert!(test.gpu.validation_messages().is_empty(), "{:#?}", test.gpu.validation_messages());
}
