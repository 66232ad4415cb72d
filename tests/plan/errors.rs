//! Every way a frame can be declared wrongly.

use ash::vk;
use gridlight::graph::{Access, Graph, Handle, ImageInfo, PlanError, plan};

use crate::{Frame, color, depth, pass};

type Make = fn(&mut Frame) -> Handle;

fn error(frame: &Frame) -> PlanError {
    plan(frame).expect_err("the graph is wrong")
}

#[test]
fn transient_read_before_any_write() {
    for access in [Access::ComputeRead, Access::ComputeReadWrite, Access::IndirectRead] {
        let mut frame = Graph::new();
        let buffer = frame.transient_buffer("counts", 64);
        frame.add_pass(pass("scan").bind(0, buffer, access));
        frame.add_pass(pass("clear").uses(buffer, Access::TransferWrite));
        let error = error(&frame);
        assert_eq!(error, PlanError::ReadBeforeWrite { pass: "scan".into(), resource: "counts".into() });
        assert_eq!(error.to_string(), "pass `scan` reads `counts`, which no earlier pass of the frame wrote");
    }
    let mut frame = Graph::new();
    let image = frame.transient_image("radiance", color());
    frame.add_pass(pass("add").uses(image, Access::ColorAttachmentBlend));
    assert_eq!(error(&frame), PlanError::ReadBeforeWrite { pass: "add".into(), resource: "radiance".into() });
}

#[test]
fn persistent_may_be_read_first() {
    let mut frame = Graph::new();
    let buffer = frame.persistent_buffer("history", 64);
    frame.add_pass(pass("use").bind(0, buffer, Access::ComputeRead));
    assert!(plan(&frame).is_ok());
}

#[test]
fn duplicate_binding() {
    let mut frame = Graph::new();
    let a = frame.imported_buffer("a");
    let b = frame.imported_buffer("b");
    frame.add_pass(pass("sum").bind(3, a, Access::ComputeRead).bind(3, b, Access::ComputeRead));
    assert_eq!(
        error(&frame),
        PlanError::DuplicateBinding { pass: "sum".into(), resource: "b".into(), binding: 3.into() }
    );
}

#[test]
fn duplicate_names() {
    let mut frame = Frame::new();
    frame.add_pass(pass("twice"));
    frame.add_pass(pass("twice"));
    assert_eq!(error(&frame), PlanError::DuplicatePass { pass: "twice".into() });
    let mut frame = Frame::new();
    frame.transient_buffer("twin", 64);
    frame.transient_image("twin", color());
    assert_eq!(error(&frame), PlanError::DuplicateResource { resource: "twin".into() });
}

#[test]
fn access_that_does_not_fit() {
    let cases: [(Make, Access); 7] = [
        (|frame| frame.transient_image("r", color()).into(), Access::IndirectRead),
        (|frame| frame.transient_image("r", color()).into(), Access::FragmentReadWrite),
        (|frame| frame.transient_image("r", color()).into(), Access::DepthAttachmentWrite),
        (|frame| frame.transient_image("r", depth()).into(), Access::ColorAttachmentWrite),
        (|frame| frame.transient_image("r", depth()).into(), Access::ComputeWrite),
        (|frame| frame.transient_buffer("r", 64).into(), Access::ComputeSampled),
        (|frame| frame.transient_image("r", color()).into(), Access::HostRead),
    ];
    for (make, access) in cases {
        let mut frame = Graph::new();
        let resource = make(&mut frame);
        frame.add_pass(pass("p").uses(resource, access));
        assert_eq!(error(&frame), PlanError::DoesNotFit { pass: "p".into(), resource: "r".into(), access });
    }
}

#[test]
fn nothing_of_zero_size() {
    let mut frame = Frame::new();
    frame.persistent_buffer("void", 0);
    assert_eq!(error(&frame), PlanError::ZeroSize { resource: "void".into() });
    let mut frame = Frame::new();
    frame.transient_image("line", ImageInfo::new(vk::Format::R32_UINT, 8, 0));
    assert_eq!(error(&frame), PlanError::ZeroSize { resource: "line".into() });
}

#[test]
fn conflicting_layouts_in_one_pass() {
    let mut frame = Graph::new();
    let image = frame.persistent_image("radiance", color());
    frame.add_pass(pass("blur").bind(0, image, Access::ComputeSampled).bind(1, image, Access::ComputeWrite));
    let error = error(&frame);
    let (first, second) = (Access::ComputeSampled, Access::ComputeWrite);
    assert_eq!(error, PlanError::Conflict { pass: "blur".into(), resource: "radiance".into(), first, second });
    assert_eq!(
        gridlight::Error::from(error).to_string(),
        "the frame graph is wrong: pass `blur` uses `radiance` as ComputeSampled and as ComputeWrite, \
         which need different layouts"
    );
}

#[test]
fn handle_of_another_graph() {
    let mut other = Frame::new();
    other.transient_buffer("a", 64);
    let stranger = other.transient_buffer("b", 64);
    let mut frame = Graph::new();
    frame.transient_buffer("a", 64);
    frame.add_pass(pass("p").uses(stranger, Access::TransferWrite));
    assert_eq!(error(&frame), PlanError::UnknownResource { pass: "p".into(), index: 1 });
}
