//! FLIP against values of its authors' implementation, flip_evaluator 1.7 (PyPI):
//! `evaluate(reference, test, "LDR", applyMagma=False)` on the same float32 pictures.

use super::*;
use crate::compare::testing::{close, image};

const WIDTH: usize = 40;
const HEIGHT: usize = 24;

fn pattern(x: usize, y: usize, c: usize) -> f32 {
    ((7 * x + 13 * y + 29 * c) % 64) as f32 / 63.0
}

fn ramp(x: usize, y: usize, c: usize) -> f32 {
    (x + 2 * y + 5 * c) as f32 / 128.0
}

fn checker(x: usize, y: usize, _: usize) -> f32 {
    ((x / 4 + y / 4) % 2) as f32
}

fn dot(x: usize, y: usize, _: usize) -> f32 {
    f32::from(u8::from(x == 16 && y == 12))
}

type Picture = fn(usize, usize, usize) -> f32;

/// The mean, and the pixels at the top left, at column 16 of row 12, and at the bottom right.
#[test]
fn values_of_the_reference_implementation() {
    let cases: [(&str, Picture, Picture, f64, [f32; 3]); 5] = [
        ("shift", pattern, |x, y, c| pattern(x + 1, y, c), 0.297_609_8, [0.759_418_2, 0.325_537_35, 0.510_643_96]),
        ("half", ramp, |x, y, c| ramp(x, y, c) / 2.0, 0.562_595_0, [0.102_614_3, 0.566_710_95, 0.778_438_8]),
        ("all", |_, _, _| 0.0, |_, _, _| 1.0, 0.967_394_3, [0.967_388_3; 3]),
        ("checker", checker, ramp, 0.765_742_8, [0.416_385_1, 0.861_605_6, 0.981_150_9]),
        ("dot", |_, _, _| 0.0, dot, 0.014_905_5, [0.0, 0.864_906_5, 0.0]),
    ];
    for (name, reference, test, mean, pixels) in cases {
        let map = flip_map(&image(WIDTH, HEIGHT, reference), &image(WIDTH, HEIGHT, test));
        println!("{name}: mean {}", map.iter().map(|v| f64::from(*v)).sum::<f64>() / map.len() as f64);
        close(map.iter().map(|v| f64::from(*v)).sum::<f64>() / map.len() as f64, mean, 2e-5);
        for (index, expected) in [0, 12 * WIDTH + 16, WIDTH * HEIGHT - 1].into_iter().zip(pixels) {
            close(map[index].into(), expected.into(), 2e-4);
        }
    }
}

#[test]
fn equal_pictures_do_not_differ() {
    let picture = image(WIDTH, HEIGHT, pattern);
    assert!(flip_map(&picture, &picture).iter().all(|v| *v == 0.0));
}

#[test]
fn one_pixel_is_enough() {
    let map = flip_map(&image(1, 1, |_, _, _| 0.0), &image(1, 1, |_, _, _| 1.0));
    assert!(map.len() == 1 && map[0] > 0.9);
}

#[test]
fn kernels_have_the_stated_sums() {
    let filters = Filters::new(PIXELS_PER_DEGREE);
    assert_eq!((filters.contrast[0][0].len(), filters.smooth.len()), (21, 19));
    for kernels in &filters.contrast {
        close(kernels.iter().map(|k| f64::from(k.iter().sum::<f32>()).powi(2)).sum(), 1.0, 1e-5);
    }
    close(filters.smooth.iter().sum::<f32>().into(), 1.0, 1e-5);
    close(filters.edge.iter().filter(|v| **v > 0.0).sum::<f32>().into(), 1.0, 1e-5);
    close(filters.point.iter().sum::<f32>().into(), 0.0, 1e-5);
}
