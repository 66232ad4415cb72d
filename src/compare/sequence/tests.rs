//! Sequences with answers known by hand. Pictures are taken as they are shown (`Tone::Srgb`), so a grey of a known luma is
//! made by decoding it.

use super::*;
use crate::compare::testing::{close, image};
use crate::compare::tone::decode_srgb;
use crate::random::{hash3, unit_float};

const SIDE: usize = 64;

/// A picture of these lumas.
fn shown(luma: impl Fn(usize, usize) -> f32) -> Image {
    image(SIDE, SIDE, |x, y, _| decode_srgb(luma(x, y)))
}

/// Uniform noise of a standard deviation.
fn noise(seed: u32, deviation: f32) -> impl Fn(usize, usize) -> f32 {
    move |x, y| (unit_float(hash3(x as u32, y as u32, seed)) - 0.5) * 12_f32.sqrt() * deviation
}

fn measure(frames: impl IntoIterator<Item = (u32, Image, Option<Image>, Image)>) -> SequenceMetrics {
    let mut meter = SequenceMeter::new(Tone::Srgb);
    for (frame, truth, second, test) in frames {
        meter.add(frame, &truth, second.as_ref(), &test).unwrap();
    }
    meter.finish().unwrap()
}

/// A gradient that brightens evenly.
fn ramp(frame: u32) -> impl Fn(usize, usize) -> f32 {
    move |x, _| 0.3 + 0.01 * frame as f32 * (x as f32 / SIDE as f32)
}

/// Lumas of each frame after plain blending with the weight `a` of the new frame.
fn blended(truth: &dyn Fn(u32, usize, usize) -> f32, frames: u32, a: f32) -> Vec<Vec<f32>> {
    let mut shown: Vec<Vec<f32>> = Vec::new();
    for frame in 0..frames {
        let at = |i: usize| {
            let new = truth(frame, i % SIDE, i / SIDE);
            shown.last().map_or(new, |before| a * new + (1.0 - a) * before[i])
        };
        let next = (0..SIDE * SIDE).map(at).collect();
        shown.push(next);
    }
    shown
}

#[test]
fn the_same_sequence_has_nothing() {
    let found = measure((0..4).map(|t| (t, shown(ramp(t)), None, shown(ramp(t)))));
    assert_eq!((found.flicker, found.block_flicker, found.lag_frames), (Some(0.0), Some(0.0), Some(0.0)));
    assert_eq!((found.pairs, found.answer.clone(), found.flip, found.relmse), (3, None, 0.0, Some(0.0)));
    close(found.energy_ratio.unwrap(), 1.0, 1e-12);
    let still = measure((0..4).map(|t| (t, shown(ramp(5)), None, shown(ramp(5)))));
    assert_eq!((still.flicker, still.lag_frames, still.answer), (Some(0.0), None, None));
}

#[test]
fn noise_flickers_by_its_deviation() {
    let (deviation, frames) = (0.02, 12);
    let noisy = |t: u32| {
        let noise = noise(t, deviation);
        shown(move |x, y| 0.5 + noise(x, y))
    };
    let found = measure((0..frames).map(|t| (t, shown(|_, _| 0.5), None, noisy(t))));
    // The difference of two frames has twice the variance; a block has 256 pixels.
    let expected = f64::from(2_f32.sqrt() * deviation) / 0.5;
    close(found.flicker.unwrap(), expected, 0.02 * expected);
    close(found.block_flicker.unwrap(), expected / 16.0, 0.15 * expected / 16.0);
    // The planted fault: noise that stays is no flicker, however much of it there is.
    let stays = measure((0..frames).map(|t| (t, shown(|_, _| 0.5), None, noisy(0))));
    assert_eq!((stays.flicker, stays.block_flicker), (Some(0.0), Some(0.0)));
    assert!(stays.relmse > Some(0.0));
}

#[test]
fn the_noise_of_two_truths_is_no_flicker() {
    let grey = |seed: u32, deviation: f32| {
        let noise = noise(seed, deviation);
        shown(move |x, y| 0.5 + noise(x, y))
    };
    let frames = |second: bool| {
        (0..12).map(move |t| (t, grey(100 + t, 0.05), second.then(|| grey(200 + t, 0.05)), grey(300 + t, 0.02)))
    };
    let expected = 2_f64.sqrt() * 0.02 / 0.5;
    close(measure(frames(true)).flicker.unwrap(), expected, 0.05 * expected);
    // One truth adds its own noise: √2 √(0.02² + 0.05²) / 0.5, 2.7 times as much.
    close(measure(frames(false)).flicker.unwrap() / expected, 7.25_f64.sqrt(), 0.05);
    assert_eq!(measure(frames(true)).lag_frames, None);
}

#[test]
fn plain_blending_lags_by_its_weight() {
    let truth = |t: u32, x: usize, y: usize| ramp(t)(x, y);
    for a in [0.2_f32, 0.5, 1.0] {
        let tests = blended(&truth, 64, a);
        // By then what the first frame was made of is forgotten: 0.8^40 is 0.01 %.
        let frames = (40..64).map(|t| {
            let test = &tests[t as usize];
            (t, shown(|x, y| truth(t, x, y)), None, shown(|x, y| test[y * SIDE + x]))
        });
        let found = measure(frames);
        close(found.lag_frames.unwrap(), f64::from((1.0 - a) / a), 0.01);
        close(found.flicker.unwrap(), 0.0, 1e-4);
    }
}

#[test]
fn the_noise_of_two_truths_is_no_lag() {
    let truth = |t: u32, x: usize, y: usize| ramp(2 * t)(x, y);
    let tests = blended(&truth, 60, 0.25);
    let noisy = |t: u32, seed: u32| {
        let noise = noise(seed + t, 0.01);
        shown(move |x, y| truth(t, x, y) + noise(x, y))
    };
    let frames = |second: bool| {
        let tests = tests.clone();
        (40..60).map(move |t| {
            let test = &tests[t as usize];
            (t, noisy(t, 100), second.then(|| noisy(t, 300)), shown(|x, y| test[y * SIDE + x]))
        })
    };
    close(measure(frames(true)).lag_frames.unwrap(), 3.0, 0.1);
    // With one truth its noise counts as movement that the test does not make.
    let biased = measure(frames(false)).lag_frames.unwrap();
    assert!((biased - 3.0).abs() > 0.3, "{biased}");
}

#[test]
fn a_step_is_answered_as_fast_as_blending_forgets() {
    let truth = |t: u32, x: usize, _: usize| if t >= 4 && x >= 20 { 0.6 } else { 0.4 };
    let measured = |a: f32| {
        let tests = blended(&truth, 24, a);
        measure((0..24).map(|t| {
            let test = &tests[t as usize];
            (t, shown(|x, y| truth(t, x, y)), None, shown(|x, y| test[y * SIDE + x]))
        }))
    };
    // 0.8^11 is the first power of 0.8 below a tenth, and the frame of the step has the first power.
    for (a, frames) in [(1.0, Some(0)), (0.95, Some(0)), (0.5, Some(3)), (0.2, Some(10)), (0.05, None)] {
        let answer = measured(a).answer.unwrap();
        assert_eq!((answer.frame, answer.frames, answer.left.len()), (4, frames, 20), "{a}");
        close(answer.left[2], f64::from(1.0 - a).powi(3), 1e-3);
    }
    // A test that never moves has all of it left, and a constant error is no part of it.
    let frozen = measure((0..24).map(|t| (t, shown(|x, y| truth(t, x, y)), None, shown(|_, _| 0.4))));
    let answer = frozen.answer.unwrap();
    assert!(answer.frames.is_none() && answer.left.iter().all(|left| (left - 1.0).abs() < 1e-3), "{answer:?}");
    let darker = measure((0..24).map(|t| (t, shown(|x, y| truth(t, x, y)), None, shown(|x, y| truth(t, x, y) - 0.1))));
    assert_eq!(darker.answer.unwrap().frames, Some(0));
}

#[test]
fn gaps_part_a_sequence() {
    let frames = [0, 1, 8, 9].map(|t| (t, shown(ramp(t)), None, shown(ramp(t))));
    assert_eq!(measure(frames).pairs, 2);
    let alone = measure([(7, shown(ramp(1)), None, shown(ramp(2)))]);
    assert_eq!((alone.pairs, alone.flicker, alone.lag_frames, alone.answer), (0, None, None, None));
    assert!(alone.relmse > Some(0.0));
}

#[test]
fn what_is_not_finite_is_in_no_measure() {
    let frames = (0..4).map(|t| {
        let mut test = shown(ramp(t));
        test.rgb[30 * t as usize] = f32::NAN;
        (t, shown(ramp(t)), None, test)
    });
    let found = measure(frames);
    assert_eq!((found.nonfinite_test_pixels, found.flicker, found.lag_frames), (4, Some(0.0), Some(0.0)));
    let limits = SequenceLimits { max_flicker: Some(1.0), ..SequenceLimits::default() };
    assert_eq!(limits.exceeded(&found), ["4 pixels of the test are NaN or infinite"]);
}

#[test]
fn every_limit_is_checked_and_named() {
    let limits = SequenceLimits {
        max_flicker: Some(0.01),
        max_block_flicker: Some(0.01),
        max_lag_frames: Some(0.5),
        max_answer_frames: Some(2.0),
        ..SequenceLimits::default()
    };
    let good = measure((0..8).map(|t| (t, shown(ramp(t / 4 * 9)), None, shown(ramp(t / 4 * 9)))));
    assert_eq!(limits.exceeded(&good), Vec::<String>::new());
    // Brightness that goes up and down, and a step that is never made.
    let flickers = |t: u32| move |_: usize, _: usize| 0.3 + 0.02 * (t % 2) as f32;
    let bad = measure((0..8).map(|t| (t, shown(ramp(t / 4 * 9)), None, shown(flickers(t)))));
    let clauses = limits.exceeded(&bad);
    let starts = ["flicker 0.", "block flicker 0.", "lag ", "the step at frame 4 is not answered within 2 frames"];
    assert_eq!(clauses.len(), 4, "{clauses:?}");
    for (clause, start) in clauses.iter().zip(starts) {
        assert!(clause.starts_with(start), "{clauses:?}");
    }
    let undefined = limits.exceeded(&measure([(0, shown(ramp(0)), None, shown(ramp(0)))]));
    assert!(undefined.len() == 4 && undefined.iter().all(|clause| clause.contains("is undefined as")), "{undefined:?}");
}

#[test]
fn frames_that_do_not_fit_are_errors() {
    let mut meter = SequenceMeter::new(Tone::Srgb);
    let (small, grey) = (image(2, 2, |_, _, _| 1.0), shown(ramp(0)));
    meter.add(3, &grey, None, &grey).unwrap();
    assert!(meter.add(3, &grey, None, &grey).is_err());
    assert!(meter.add(4, &small, None, &small).is_err());
    assert!(meter.add(4, &grey, Some(&small), &grey).is_err());
    assert!(meter.add(4, &grey, None, &small).is_err());
    assert!(SequenceMeter::new(Tone::Srgb).finish().is_err());
}
