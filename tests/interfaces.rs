//! Passes against the interfaces of their shaders, without a device: a pass that fits, and each fault that is planted.

use ash::vk;
use gridlight::gpu::{ComputeWork, Dispatch, Fault, InterfaceError, Repeat, Work, check_interfaces};
use gridlight::graph::{Access, Graph, ImageInfo, Pass};
use gridlight::passes::{Extent, shader};
use gridlight::shader::interface::{BindingKind, ImageDimension};
use gridlight::shader::spirv;

/// Binding and access of each resource of `blur.comp`, with whether it is an image.
type Bound = Vec<(&'static str, Access, bool)>;

fn blur() -> (ComputeWork, Bound) {
    let constants = vec![("AXIS", 0), ("READS_INTERLEAVED", 1), ("WEIGHTED", 0)];
    let bound = vec![
        ("frame", Access::ComputeUniform, false),
        ("input_image", Access::ComputeSampled, true),
        ("edges", Access::ComputeRead, false),
        ("out_image", Access::ComputeWrite, true),
        ("depth_image", Access::ComputeSampled, true),
    ];
    (ComputeWork { constants, ..shader("interleave/blur", Dispatch::groups(1)) }, bound)
}

fn check(work: ComputeWork, bound: &Bound) -> Result<(), InterfaceError> {
    let mut graph = Graph::new();
    let mut pass = Pass::new("blur", Work::Compute(work));
    for (index, (name, access, is_image)) in bound.iter().enumerate() {
        let resource = format!("resource {index}");
        let info = ImageInfo::new(vk::Format::R32G32B32A32_SFLOAT, 8, 8);
        pass = if *is_image {
            pass.bind(*name, graph.persistent_image(&resource, info), *access)
        } else {
            pass.bind(*name, graph.persistent_buffer(&resource, 64), *access)
        };
    }
    graph.add_pass(pass);
    check_interfaces(&graph)
}

/// What is found once a fault is planted in a pass that fits.
fn planted(plant: impl FnOnce(&mut ComputeWork, &mut Bound)) -> Fault {
    let (mut work, mut bound) = blur();
    plant(&mut work, &mut bound);
    let error = check(work, &bound).unwrap_err();
    assert_eq!(error.pass, "blur");
    error.fault
}

#[test]
fn a_pass_that_fits() {
    let (work, bound) = blur();
    assert_eq!(check(work, &bound), Ok(()));
}

#[test]
fn bindings_that_do_not_fit() {
    assert_eq!(
        planted(|_, bound| {
            bound.remove(2);
        }),
        Fault::MissingBinding("edges".into())
    );
    let extra = ("edgse", Access::ComputeRead, false);
    assert_eq!(planted(|_, bound| bound.push(extra)), Fault::ExtraBinding("edgse".into()));
    let (binding, bound, wanted) = ("edges".to_owned(), BindingKind::UniformBuffer, BindingKind::StorageBuffer);
    let wrong_kind = Fault::WrongKind { binding, bound, wanted };
    assert_eq!(planted(|_, bound| bound[2].1 = Access::ComputeUniform), wrong_kind);
    let (binding, bound, wanted) = ("depth_image".into(), BindingKind::StorageImage, BindingKind::SampledImage);
    let wrong_kind = Fault::WrongKind { binding, bound, wanted };
    assert_eq!(planted(|_, bound| bound[4].1 = Access::ComputeRead), wrong_kind);
    assert_eq!(planted(|_, bound| bound[2].1 = Access::FragmentRead), Fault::WrongStage("edges".into()));
}

#[test]
fn reads_and_writes_that_are_not_the_shaders() {
    // `edges` is a readonly block.
    assert_eq!(planted(|_, bound| bound[2].1 = Access::ComputeReadWrite), Fault::NeverWritten("edges".into()));
    assert_eq!(planted(|_, bound| bound[3].1 = Access::ComputeRead), Fault::UndeclaredWrite("out_image".into()));
    let sums = |access| {
        let mut graph = Graph::new();
        let info = ImageInfo::new(vk::Format::R32G32B32A32_SFLOAT, 8, 8);
        let [radiance, sum, mean] = ["radiance", "sum", "mean"].map(|name| graph.persistent_image(name, info));
        let frame = graph.persistent_buffer("frame data", 512);
        let pass = Pass::new("sum", Work::Compute(shader("accumulate/add_frame", Extent::Pixels([8, 8]))))
            .bind("frame", frame, Access::ComputeUniform)
            .bind("frame_image", radiance, Access::ComputeSampled)
            .bind("sum_image", sum, access)
            .bind("out_mean", mean, Access::ComputeWrite);
        graph.add_pass(pass);
        check_interfaces(&graph).map_err(|error| error.fault)
    };
    assert_eq!(sums(Access::ComputeReadWrite), Ok(()));
    assert_eq!(sums(Access::ComputeWrite), Err(Fault::UndeclaredRead("sum_image".into())));
}

#[test]
fn images_of_another_dimension() {
    let flat = ImageInfo::new(vk::Format::R32_UINT, 8, 8);
    let (array, volume) = (flat.with_layers(2), flat.with_depth(2));
    let check = |shader_name: &str, info| {
        let mut graph = Graph::new();
        let image = graph.persistent_image("image", info);
        let sums = graph.persistent_buffer("sums", 64);
        let pass = Pass::new("sum", Work::Compute(shader(shader_name, Dispatch::groups(1))))
            .bind("texels", image, Access::ComputeSampled)
            .bind("sums", sums, Access::ComputeWrite);
        graph.add_pass(pass);
        check_interfaces(&graph).map_err(|error| error.fault)
    };
    let kinds = [
        ("tests/sum_texels", flat, ImageDimension::D2),
        ("tests/sum_texels_layers", array, ImageDimension::D2Array),
        ("tests/sum_texels_volume", volume, ImageDimension::D3),
    ];
    for (shader, _, wanted) in kinds {
        for (_, info, bound) in kinds {
            let fault = Fault::WrongDimension { binding: "texels".into(), bound, wanted };
            assert_eq!(check(shader, info), if bound == wanted { Ok(()) } else { Err(fault) });
        }
    }
}

#[test]
fn constants_that_do_not_fit() {
    let shader = || "interleave/blur.comp".to_owned();
    let pushed = |given| Fault::PushSize { shader: shader(), given, wanted: 0 };
    assert_eq!(planted(|work, _| work.push.push(7)), pushed(4));
    assert_eq!(planted(|work, _| work.repeat = Some(Repeat { rounds: 1, parts: 1 })), pushed(8));
    assert_eq!(planted(|work, _| work.constants[0].0 = "AXLE"), Fault::ExtraConstant("AXLE".into()));
    assert_eq!(
        planted(|work, _| {
            work.constants.pop();
        }),
        Fault::MissingConstant("WEIGHTED".into())
    );
    assert_eq!(planted(|work, _| work.uses_scene = true), Fault::Scene);
    assert_eq!(planted(|work, _| work.shader = "blur.comp".into()), Fault::NoShader("blur.comp".into()));
}

#[test]
fn workgroups_follow_from_the_shader() {
    let groups = |extent: Extent, size| match extent.dispatch(size) {
        Dispatch::Groups(groups) => groups,
        Dispatch::Indirect { .. } => panic!("indirect"),
    };
    assert_eq!(groups(Extent::Threads(257), [256, 1, 1]), [2, 1, 1]);
    assert_eq!(groups(Extent::Threads(0), [64, 1, 1]), [1, 1, 1]);
    assert_eq!(groups(Extent::Pixels([17, 8]), [8, 8, 1]), [3, 1, 1]);
    assert!(matches!(shader("interleave/blur", Extent::Pixels([16, 9])).dispatch, Dispatch::Groups([2, 2, 1])));
}

/// Two resources at one binding: the validation layer does not survive some of them.
#[test]
fn no_shader_has_two_resources_at_one_binding() {
    let doubled = |places: &[(u32, u32)]| {
        let distinct: std::collections::BTreeSet<_> = places.iter().collect();
        distinct.len() < places.len()
    };
    for name in spirv::names() {
        let places: Vec<_> = spirv::interface(name).unwrap().bindings.iter().map(|b| (b.set, b.binding)).collect();
        assert!(!doubled(&places), "{name} has two resources at one binding: {places:?}");
    }
    assert!(doubled(&[(0, 1), (1, 1), (0, 1)]));
}
