//! Further rounds of samples in a frame (`passes/rounds.rs`): each counts as a frame.

use gridlight::renderer::Fresh;
use gridlight::scene::Scene;
use gridlight::settings::{Antilag, IndirectSize, Settings, ShadowEstimate, Size, Temporal};
use gridlight::uploaded_scene::UploadedScene;

use crate::common::picture::{SIZES, Texel};
use crate::common::rooms::furnished_room;
use crate::common::{GpuTest, gpu};
use crate::run::{Run, settings};
use crate::tiles::{lamp_settings, lit_from};

/// A size at which tiles are cut off.
const SIZE: Size = SIZES[4];
const ROUNDS: u32 = 5;

fn with_rounds(size: Size, estimate: ShadowEstimate, rounds: u32) -> Settings {
    settings(size, Temporal::Shadows, estimate).changed(|s| s.lgh.temporal_rounds = Some(rounds))
}

/// Means over the frames, and the same for the filter, as the last round has left them.
fn means(run: &Run<'_>, rounds: u32) -> [Vec<Texel>; 4] {
    let pass = if rounds == 1 { "temporal/blend".to_owned() } else { format!("temporal/blend/{rounds}") };
    let frame = run.last();
    ["temporal_shadowed", "temporal_unshadowed", "shadowed_blended", "unshadowed_blended"]
        .map(|image| frame.floats(&pass, image))
}

/// Numbers of frames in the history of every pixel with a surface.
fn frame_counts(run: &Run<'_>, rounds: u32) -> Vec<f64> {
    means(run, rounds)[0].iter().map(|texel| texel[3]).filter(|frames| *frames > 0.0).collect()
}

/// A first frame with several rounds, and as many frames with one, whose samples have the number of the frame.
fn rounds_and_frames(test: &GpuTest, settings: &Settings, number: fn(u32) -> u32) -> [[Vec<Texel>; 4]; 2] {
    let scene = furnished_room();
    let mut rounds = Run::new(&test.gpu, &scene, settings);
    rounds.next();
    let plain = settings.clone().changed(|s| s.lgh.temporal_rounds = Some(1));
    let mut frames = Run::new(&test.gpu, &scene, &plain);
    for frame in 0..ROUNDS {
        frames.frames = number(frame);
        frames.next_with(Fresh::Shadows);
    }
    [means(&rounds, settings.lgh.temporal_rounds.unwrap()), means(&frames, 1)]
}

/// Rounds from the second on have the numbers from 2^31 + 2 on, where frames never come.
fn number_of_round(frame: u32) -> u32 {
    if frame == 0 { 0 } else { 0x8000_0001 + frame }
}

/// To the bit, means and deviations: rounds of the first frame are what so many frames would be that have the same samples.
#[test]
fn rounds_are_frames() {
    let test = gpu();
    let estimates = [ShadowEstimate::Ratio, ShadowEstimate::Corrected, ShadowEstimate::Unbiased];
    for (size, estimate) in SIZES.into_iter().zip(estimates.into_iter().cycle()) {
        let [rounds, frames] = rounds_and_frames(&test, &with_rounds(size, estimate, ROUNDS), number_of_round);
        assert!(rounds == frames, "{size}, {estimate:?}");
    }
    let of = |change: fn(&mut Settings)| with_rounds(SIZE, ShadowEstimate::Corrected, ROUNDS).changed(change);
    let others = [
        ("half the picture", of(|s| s.lgh.indirect_size = IndirectSize::Half)),
        ("tiles", of(|s| s.lgh.antilag = Antilag::Tiles)),
        ("lights as first level", of(|s| s.lgh.first_level = 0)),
    ];
    for (what, settings) in others {
        let [rounds, frames] = rounds_and_frames(&test, &settings, number_of_round);
        assert!(rounds == frames, "{what}");
    }
    let settings = with_rounds(SIZE, ShadowEstimate::Corrected, ROUNDS);
    // Frame 1 follows the first frame, and must not have the samples that it had already.
    let [rounds, frames] = rounds_and_frames(&test, &settings, |frame| frame);
    assert!(rounds != frames, "rounds have the samples of the frames that follow");
    let fewer = settings.changed(|s| s.lgh.temporal_rounds = Some(ROUNDS - 1));
    let [rounds, frames] = rounds_and_frames(&test, &fewer, number_of_round);
    assert!(rounds != frames, "a round less is not noticed");
}

/// How steps of `--max-submit-ms` divide a frame is nothing to it.
#[test]
fn submissions_change_nothing() {
    let test = gpu();
    let [whole, divided] = [1000.0, 0.01].map(|max_submit_ms| {
        let settings = with_rounds(SIZE, ShadowEstimate::Corrected, ROUNDS);
        let settings = settings.changed(|s| s.device.max_submit_ms = max_submit_ms);
        let mut run = Run::new(&test.gpu, &furnished_room(), &settings);
        (0..3).for_each(|_| run.next());
        run.radiance()
    });
    assert!(whole == divided && whole.iter().any(|value| *value > 0.01));
}

/// Shadow rays of the last frame.
fn rays(run: &Run<'_>) -> u32 {
    let counts: Vec<u32> = run.last().written.all("shadow_rays/5", "ray_count");
    counts[1]
}

/// Histories that are long enough grow by one in every frame, and no others are left.
#[test]
fn only_short_histories_take_rounds() {
    let test = gpu();
    let settings = with_rounds(SIZE, ShadowEstimate::Corrected, ROUNDS);
    let mut run = Run::new(&test.gpu, &furnished_room(), &settings);
    run.next();
    let first = rays(&run);
    assert!(frame_counts(&run, ROUNDS).iter().all(|frames| *frames == f64::from(ROUNDS)));
    run.next();
    let second = rays(&run);
    assert!(frame_counts(&run, ROUNDS).iter().all(|frames| *frames == f64::from(ROUNDS + 1)));
    let tiles: Vec<u32> = run.last().written.all("temporal/blend", "round_tiles_2");
    assert!(!tiles.is_empty() && tiles.iter().all(|word| *word == 0), "{tiles:?}");
    assert!(first > 4 * second && second > 100, "{first} rays in the first frame, {second} in the second");
    // What comes into sight takes rounds until it has four frames, and what was in sight goes on.
    run.step_right(0.3);
    run.next();
    let third = rays(&run);
    let frames = frame_counts(&run, ROUNDS);
    let [anew, on] = [4.0, f64::from(ROUNDS + 2)].map(|count| frames.iter().filter(|n| n.round() == count).count());
    assert!(frames.iter().all(|n| *n >= 3.5), "a history is short");
    assert!(anew > 20 && on > frames.len() / 2, "{anew} begin anew and {on} of {} go on", frames.len());
    assert!(third > second && third < first, "{third} rays, {first} in the first frame, {second} in the second");
}

/// A mean that forgets faster is never so long, and takes as many rounds as it can hold.
#[test]
fn rounds_end_where_weights_do() {
    let test = gpu();
    let settings = with_rounds(SIZE, ShadowEstimate::Corrected, ROUNDS);
    let settings = settings.changed(|s| s.lgh.temporal_weight = Some(0.4));
    let mut run = Run::new(&test.gpu, &furnished_room(), &settings);
    run.next();
    assert!(run.last().written.get::<[f32; 4]>("temporal/blend/4", "temporal_shadowed").is_none(), "a fourth round");
    let frames = frame_counts(&run, 3);
    assert!(!frames.is_empty() && frames.iter().all(|n| (n - 2.5).abs() < 1e-6 || *n == 2.0), "{frames:?}");
}

/// Where tiles give up their history, the same frame gathers it anew.
#[test]
fn what_tiles_give_up_is_gathered_in_the_same_frame() {
    let test = gpu();
    let settings = lamp_settings(Antilag::Tiles).changed(|s| s.lgh.temporal_rounds = Some(ROUNDS));
    let mut run = Run::new(&test.gpu, &lit_from(-1.0), &settings);
    (0..12).for_each(|_| run.next());
    let turned: Scene = lit_from(1.0);
    let turned = UploadedScene::new(&test.gpu, &turned).unwrap();
    run.renderer.update_lights(turned.other_lights()).unwrap();
    run.next();
    let [given_up, gathered] = [1, ROUNDS].map(|rounds| frame_counts(&run, rounds));
    let short = |frames: &[f64]| frames.iter().filter(|n| **n < 3.5).count();
    assert!(short(&given_up) > given_up.len() / 20, "{} pixels give up their history", short(&given_up));
    assert_eq!(short(&gathered), 0, "pixels whose history is short");
}
