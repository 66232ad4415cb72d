//! Seeded random frames, planned and judged.

use gridlight::graph::{
    Access, Barrier, Graph, Handle, ImageDepth, ImageInfo, Lifetime, Part, Pass, Plan, PlannedPass, Requirement,
    Resource, ResourceInfo, add_alias_barriers, assign, hoist, plan,
};

use crate::{Frame, Lcg, checker, color, depth};

const ACCESSES: [Access; 27] = [
    Access::ComputeRead,
    Access::ComputeWrite,
    Access::ComputeReadWrite,
    Access::ComputeSampled,
    Access::ComputeUniform,
    Access::VertexRead,
    Access::GraphicsUniform,
    Access::GraphicsRead,
    Access::FragmentRead,
    Access::FragmentReadWrite,
    Access::FragmentSampled,
    Access::ColorAttachmentWrite,
    Access::ColorAttachmentBlend,
    Access::DepthAttachmentWrite,
    Access::DepthAttachmentRead,
    Access::DepthAttachmentReadSampled,
    Access::IndirectRead,
    Access::VertexBuffer,
    Access::IndexBuffer,
    Access::ComputeTrace,
    Access::StructureInput,
    Access::StructureReference,
    Access::StructureBuild,
    Access::StructureScratch,
    Access::TransferRead,
    Access::TransferWrite,
    Access::HostRead,
];

/// A resource of any lifetime, or a pair that changes places.
fn random_resource(frame: &mut Frame, random: &mut Lcg, name: &str) -> Vec<Handle> {
    let one = match random.below(21) {
        0 => frame.imported_buffer(name).into(),
        1 => frame.persistent_buffer(name, 64).into(),
        2 => frame.persistent_image(name, color()).into(),
        3 => frame.persistent_image(name, depth()).into(),
        4 => frame.transient_image(name, color()).into(),
        5 => frame.transient_image(name, depth()).into(),
        6 => frame.acquired_image(name, color()).into(),
        7 => frame.continued_image(name, color()).into(),
        8 => frame.readback_buffer(name, 64).into(),
        9 => frame.imported_image(name, color().format).into(),
        10 => {
            let pair = frame.history_buffer(name, 64);
            return vec![pair.previous.into(), pair.current.into()];
        }
        11 => {
            let pair = frame.history_image(name, if random.below(2) == 0 { color() } else { depth() });
            return vec![pair.previous.into(), pair.current.into()];
        }
        12 => frame.transient_image(name, levels(random)).into(),
        13 => frame.persistent_image(name, levels(random)).into(),
        14 => {
            let pair = frame.history_image(name, levels(random));
            return vec![pair.previous.into(), pair.current.into()];
        }
        _ => frame.transient_buffer(name, 64).into(),
    };
    vec![one]
}

/// An image with two or three mip levels, sometimes with layers or in three dimensions.
fn levels(random: &mut Lcg) -> ImageInfo {
    let info = color().with_levels(2 + random.below(2) as u32);
    match random.below(3) {
        0 => info.with_layers(3),
        1 => info.with_depth(5),
        _ => info,
    }
}

/// An access that fits a resource, or one level of it; one that reads only where there are contents.
fn random_access(resource: &Resource, of_level: bool, has_contents: bool, random: &mut Lcg) -> Access {
    let is_flat = !matches!(resource.info, ResourceInfo::Image(info) if info.depth != ImageDepth::Flat);
    let fitting: Vec<Access> = ACCESSES
        .into_iter()
        .filter(|access| access.fits(resource.info.kind()))
        .filter(|access| is_flat || !access.is_attachment())
        .filter(|access| of_level || resource.info.level_count() == 1 || access.takes_levels())
        .filter(|access| !only_read(resource.lifetime) || !access.is_write())
        .filter(|access| !resource.lifetime.starts_empty() || has_contents || !access.is_read())
        .collect();
    fitting[random.below(fitting.len())]
}

/// What a pass does with a resource: with all of it at once, or with some of its levels, each in its own way. `written`
/// says which levels have been written.
fn random_uses(resource: &Resource, handle: Handle, written: &mut [bool], random: &mut Lcg) -> Vec<(Part, Access)> {
    if written.len() == 1 || random.below(2) == 0 {
        let access = random_access(resource, false, written.iter().all(|written| *written), random);
        written.iter_mut().for_each(|written| *written |= access.is_write());
        return vec![(handle.into(), access)];
    }
    let mut uses = Vec::new();
    for (level, written) in written.iter_mut().enumerate() {
        if random.below(3) > 0 {
            let access = random_access(resource, true, *written, random);
            *written |= access.is_write();
            uses.push((Part { resource: handle, level: Some(level as u32) }, access));
        }
    }
    uses
}

fn random_frame(random: &mut Lcg) -> Frame {
    let mut frame = Graph::new();
    let count = 1 + random.below(8);
    let handles: Vec<Handle> =
        (0..count).flat_map(|index| random_resource(&mut frame, random, &format!("resource {index}"))).collect();
    let level_count = |handle: &Handle| frame.resources()[handle.index()].info.level_count() as usize;
    let mut written: Vec<Vec<bool>> = handles.iter().map(|handle| vec![false; level_count(handle)]).collect();
    for index in 0..1 + random.below(10) {
        let mut pass = Pass::new(format!("pass {index}"), ());
        for (slot, &handle) in handles.iter().enumerate() {
            if random.below(2) == 0 {
                continue;
            }
            let resource = &frame.resources()[handle.index()];
            let uses = random_uses(resource, handle, &mut written[slot], random);
            pass = uses.into_iter().fold(pass, |pass, (part, access)| pass.uses(part, access));
        }
        frame.add_pass(if random.below(6) == 0 { pass.repeated() } else { pass });
    }
    renew_histories(&mut frame, &handles, &written);
    let shown = |slot: &usize| frame.resources()[handles[*slot].index()].lifetime.is_acquired() && written[*slot][0];
    let ends: Vec<Handle> = (0..handles.len()).filter(shown).map(|slot| handles[slot]).collect();
    if !ends.is_empty() {
        let present = Pass::new("present", ());
        frame.add_pass(ends.into_iter().fold(present, |pass, image| pass.uses(image, Access::Present)));
    }
    frame
}

fn only_read(lifetime: Lifetime) -> bool {
    matches!(lifetime, Lifetime::Previous { .. })
}

/// A pass that writes what has to be written in every frame and was not.
fn renew_histories(frame: &mut Frame, handles: &[Handle], written: &[Vec<bool>]) {
    let stale = |slot: &usize| {
        let resource = &frame.resources()[handles[*slot].index()];
        matches!(resource.lifetime, Lifetime::Current { .. }) && written[*slot].contains(&false)
    };
    let stale: Vec<Handle> = (0..handles.len()).filter(stale).map(|slot| handles[slot]).collect();
    if !stale.is_empty() {
        let renew = Pass::new("renew", ());
        frame.add_pass(stale.into_iter().fold(renew, |pass, current| pass.uses(current, Access::TransferWrite)));
    }
}

fn random_requirements(frame: &Frame, random: &mut Lcg) -> Vec<Option<Requirement>> {
    let requirement = |resource: &Resource| {
        let image = matches!(resource.info, ResourceInfo::Image(_));
        (resource.lifetime == Lifetime::Transient).then(|| Requirement {
            size_bytes: 1 + random.below(1000) as u64,
            alignment: 1 << random.below(8),
            class: u32::from(image && random.below(4) == 0),
        })
    };
    frame.resources().iter().map(requirement).collect()
}

/// The planted faults: the plan without one of its barriers, with that barrier.
fn without_one_barrier(plan: &Plan) -> Vec<(Plan, Barrier)> {
    let lists: [fn(&mut PlannedPass) -> &mut Vec<Barrier>; 2] = [|p| &mut p.barriers, |p| &mut p.between];
    let mut all = Vec::new();
    for (pass, list) in (0..plan.passes.len()).flat_map(|pass| lists.map(|list| (pass, list))) {
        for barrier in 0..list(&mut plan.clone().passes[pass]).len() {
            let mut broken = plan.clone();
            let gone = list(&mut broken.passes[pass]).remove(barrier);
            all.push((broken, gone));
        }
    }
    for barrier in 0..plan.release.len() {
        let mut broken = plan.clone();
        let gone = broken.release.remove(barrier);
        all.push((broken, gone));
    }
    all
}

#[test]
fn random_frames_have_no_hazards_and_no_needless_barrier() {
    let mut random = Lcg(1);
    let (mut removed, mut saved, mut moved, mut missed) = (0, 0, 0, 0);
    for round in 0..2000 {
        let frame = random_frame(&mut random);
        let mut planned = plan(&frame).unwrap_or_else(|error| panic!("round {round}: {error}"));
        checker::check(&frame, &planned, None).unwrap_or_else(|hazard| panic!("round {round}: {hazard}"));
        for (broken, gone) in without_one_barrier(&planned) {
            assert!(checker::check(&frame, &broken, None).is_err(), "round {round}: nobody misses {gone:?}");
            removed += 1;
        }
        let before = planned.batch_count();
        hoist(&mut planned, &frame);
        checker::check(&frame, &planned, None).unwrap_or_else(|hazard| panic!("round {round}, hoisted: {hazard}"));
        saved += before.checked_sub(planned.batch_count()).expect("no more batches than before");
        for (broken, _) in without_one_barrier(&planned) {
            moved += 1;
            missed += usize::from(checker::check(&frame, &broken, None).is_err());
        }
    }
    assert!(removed > 6_000, "only {removed} barriers were put to the test");
    assert!(saved > 600, "only {saved} batches were saved");
    // A later reader's barrier may have moved before an earlier reader, which then has two.
    assert!(100 * missed > 98 * moved, "{missed} of {moved} moved barriers were missed");
}

#[test]
fn random_frames_share_memory_without_hazards() {
    let mut random = Lcg(2);
    let (mut unaware, mut takeovers, mut missed) = (0, 0, 0);
    for round in 0..2000 {
        let frame = random_frame(&mut random);
        let mut planned = plan(&frame).unwrap_or_else(|error| panic!("round {round}: {error}"));
        let requirements = random_requirements(&frame, &mut random);
        let alias = assign(&planned.lifetimes, &requirements);
        let placed = Some((&alias, requirements.as_slice()));
        let wrong = checker::check(&frame, &planned, placed).is_err();
        add_alias_barriers(&mut planned, &frame, &requirements, &alias);
        assert!(
            !wrong || planned.passes.iter().any(|p| p.takeover.is_some()),
            "round {round}: a hazard without sharing"
        );
        unaware += usize::from(wrong);
        for hoisted in [false, true] {
            if hoisted {
                hoist(&mut planned, &frame);
            }
            let hazards = checker::check(&frame, &planned, placed);
            hazards.unwrap_or_else(|hazard| panic!("round {round}, hoisted {hoisted}: {hazard}"));
            for pass in (0..planned.passes.len()).filter(|pass| planned.passes[*pass].takeover.is_some()) {
                let mut broken = planned.clone();
                broken.passes[pass].takeover = None;
                takeovers += 1;
                missed += usize::from(checker::check(&frame, &broken, placed).is_err());
            }
        }
    }
    assert!(unaware > 100, "only {unaware} frames were wrong before the alias barriers");
    // A few are covered by what orders an image's transition, or by another resource's on the same memory.
    assert!(missed > 300 && 10 * missed > 7 * takeovers, "{missed} of {takeovers} memory barriers were missed");
}
