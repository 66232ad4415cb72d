//! Seeded random frames, planned and judged.

use gridlight::graph::{
    Access, Graph, Handle, Lifetime, Pass, Requirement, ResourceInfo, add_alias_barriers, assign, plan,
};

use crate::{Frame, Lcg, checker, color, depth};

const ACCESSES: [Access; 22] = [
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
    Access::TransferRead,
    Access::TransferWrite,
    Access::HostRead,
];

fn random_frame(random: &mut Lcg) -> Frame {
    let mut frame = Graph::new();
    let handles: Vec<Handle> = (0..1 + random.below(8))
        .map(|index| {
            let name = format!("resource {index}");
            match random.below(8) {
                0 => frame.imported_buffer(&name, 64).into(),
                1 => frame.persistent_buffer(&name, 64).into(),
                2 => frame.persistent_image(&name, color()).into(),
                3 => frame.persistent_image(&name, depth()).into(),
                4 => frame.transient_image(&name, color()).into(),
                5 => frame.transient_image(&name, depth()).into(),
                _ => frame.transient_buffer(&name, 64).into(),
            }
        })
        .collect();
    let mut written = vec![false; handles.len()];
    for index in 0..1 + random.below(10) {
        let mut pass = Pass::new(format!("pass {index}"), ());
        for (slot, &handle) in handles.iter().enumerate() {
            if random.below(2) == 0 {
                continue;
            }
            let resource = &frame.resources()[handle.index()];
            let fitting: Vec<Access> = ACCESSES
                .into_iter()
                .filter(|access| access.fits(resource.info.kind()))
                .filter(|access| resource.lifetime != Lifetime::Imported || !access.is_write())
                .filter(|access| resource.lifetime != Lifetime::Transient || written[slot] || !access.is_read())
                .collect();
            let access = fitting[random.below(fitting.len())];
            written[slot] |= access.is_write();
            pass = pass.uses(handle, access);
        }
        frame.add_pass(pass);
    }
    frame
}

fn random_requirements(frame: &Frame, random: &mut Lcg) -> Vec<Option<Requirement>> {
    let requirement = |resource: &gridlight::graph::Resource| {
        let image = matches!(resource.info, ResourceInfo::Image(_));
        (resource.lifetime == Lifetime::Transient).then(|| Requirement {
            size_bytes: 1 + random.below(1000) as u64,
            alignment: 1 << random.below(8),
            class: u32::from(image && random.below(4) == 0),
        })
    };
    frame.resources().iter().map(requirement).collect()
}

#[test]
fn random_frames_have_no_hazards_and_no_needless_barrier() {
    let mut random = Lcg(1);
    let mut removed = 0;
    for round in 0..2000 {
        let frame = random_frame(&mut random);
        let planned = plan(&frame).unwrap_or_else(|error| panic!("round {round}: {error}"));
        checker::check(&frame, &planned, None).unwrap_or_else(|hazard| panic!("round {round}: {hazard}"));
        // The planted fault: without any one of its barriers, the plan must be found wrong.
        for pass in 0..planned.passes.len() {
            for barrier in 0..planned.passes[pass].barriers.len() {
                let mut broken = planned.clone();
                let gone = broken.passes[pass].barriers.remove(barrier);
                assert!(
                    checker::check(&frame, &broken, None).is_err(),
                    "round {round}: nobody misses {gone:?} of pass {pass}"
                );
                removed += 1;
            }
        }
    }
    assert!(removed > 10_000, "only {removed} barriers were put to the test");
}

#[test]
fn random_frames_share_memory_without_hazards() {
    let mut random = Lcg(2);
    let (mut shared, mut red) = (0, 0);
    for round in 0..2000 {
        let frame = random_frame(&mut random);
        let mut planned = plan(&frame).unwrap_or_else(|error| panic!("round {round}: {error}"));
        let requirements = random_requirements(&frame, &mut random);
        let alias = assign(&planned.lifetimes, &requirements);
        let placed = Some((&alias, requirements.as_slice()));
        let unaware = checker::check(&frame, &planned, placed).is_err();
        let before = planned.clone();
        add_alias_barriers(&mut planned, &frame, &requirements, &alias);
        checker::check(&frame, &planned, placed).unwrap_or_else(|hazard| panic!("round {round}: {hazard}"));
        let widened = before.passes.iter().zip(&planned.passes).any(|(a, b)| a != b);
        shared += usize::from(widened);
        red += usize::from(unaware);
        assert!(widened || !unaware, "round {round}: a hazard without sharing");
    }
    assert!(shared > 100 && red > 100, "{shared} frames shared memory, {red} were wrong before the alias barriers");
}
