//! Passes whose results later frames use again.

use gridlight::graph::{Access, Graph, Handle, Lifetime};

use crate::{Frame, pass, planned};

fn lifetime(frame: &Frame, resource: impl Into<Handle>) -> Lifetime {
    frame.resources()[resource.into().index()].lifetime
}

fn kept_passes(frame: &Frame) -> Vec<&str> {
    frame.passes().iter().filter(|pass| pass.is_kept).map(|pass| pass.name.as_str()).collect()
}

#[test]
fn what_others_read_of_kept_passes_outlives_the_frame() {
    let mut frame = Graph::new();
    let [constants, counter] = ["constants", "counter"].map(|name| frame.transient_buffer(name, 64));
    let [slots, lights] = ["slots", "lights"].map(|name| frame.transient_buffer(name, 64));
    frame.add_pass(pass("setup").uses(constants, Access::TransferWrite).uses(counter, Access::TransferWrite));
    let trace = pass("trace").bind(0, constants, Access::ComputeUniform).bind(1, slots, Access::ComputeWrite);
    frame.add_pass(trace.bind(2, counter, Access::ComputeReadWrite));
    frame.add_pass(pass("pack").bind(0, slots, Access::ComputeRead).bind(1, lights, Access::ComputeWrite));
    frame.keep_from(1);
    let shade = pass("shade").bind(0, lights, Access::ComputeRead).bind(1, constants, Access::ComputeUniform);
    frame.add_pass(shade.bind(2, counter, Access::ComputeReadWrite));
    frame.keep_results();
    planned(&frame);
    assert_eq!(kept_passes(&frame), ["trace", "pack"]);
    assert_eq!(lifetime(&frame, lights), Lifetime::Persistent);
    // The kept passes' alone, and what every frame begins anew.
    for resource in [slots, constants, counter] {
        assert_eq!(lifetime(&frame, resource), Lifetime::Transient);
    }
}

#[test]
fn what_others_write_later_is_not_kept() {
    let mut frame = Graph::new();
    let lights = frame.transient_buffer("lights", 64);
    frame.add_pass(pass("trace").bind(0, lights, Access::ComputeWrite));
    frame.keep_from(0);
    frame.add_pass(pass("sort").bind(0, lights, Access::ComputeReadWrite));
    frame.keep_results();
    planned(&frame);
    assert_eq!(kept_passes(&frame), [""; 0]);
    assert_eq!(lifetime(&frame, lights), Lifetime::Transient);
}
