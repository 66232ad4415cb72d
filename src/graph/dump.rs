//! The planned frame as a Graphviz drawing.

use std::fmt::Write as _;

use super::builder::Graph;
use super::plan::Plan;
use super::resource::{ImageDepth, ImageInfo, Lifetime, Resource, ResourceInfo};

/// Draws passes as boxes (with their barrier counts) in a chain, resources as ellipses (with size and lifetime), and
/// every use as an arrow labelled with its access and binding: into the pass if it reads, out of it if it writes.
#[must_use]
pub fn to_dot<P>(graph: &Graph<P>, plan: &Plan) -> String {
    let mut dot = String::from("digraph frame {\n  rankdir=LR;\n  node [fontname=\"monospace\"];\n");
    for (index, resource) in graph.resources().iter().enumerate() {
        let style = match resource.lifetime {
            Lifetime::Transient => "dashed",
            Lifetime::Persistent | Lifetime::Previous { .. } | Lifetime::Current { .. } => "solid",
            Lifetime::Imported | Lifetime::Acquired | Lifetime::Continued | Lifetime::Readback => "bold",
        };
        line(&mut dot, &format!("r{index} [shape=ellipse, style={style}, label=\"{}\"];", resource_label(resource)));
    }
    for (index, (pass, planned)) in graph.passes().iter().zip(&plan.passes).enumerate() {
        let count = planned.barriers.len();
        let plural = if count == 1 { "" } else { "s" };
        let label = format!("{}\\n{count} barrier{plural}", escape(&pass.name));
        line(&mut dot, &format!("p{index} [shape=box, label=\"{label}\"];"));
        if index > 0 {
            line(&mut dot, &format!("p{} -> p{index} [style=dotted, arrowhead=none, weight=10];", index - 1));
        }
        for used in &pass.uses {
            let resource = used.resource.index();
            let binding = used.binding.map_or_else(String::new, |binding| format!(" @{binding}"));
            let level = used.level.map_or_else(String::new, |level| format!(" level {level}"));
            let label = format!("[label=\"{:?}{level}{binding}\"]", used.access);
            if used.access.is_read() {
                line(&mut dot, &format!("r{resource} -> p{index} {label};"));
            }
            if used.access.is_write() {
                line(&mut dot, &format!("p{index} -> r{resource} {label};"));
            }
        }
    }
    dot.push_str("}\n");
    dot
}

fn line(dot: &mut String, text: &str) {
    writeln!(dot, "  {text}").expect("writing to a string cannot fail");
}

fn resource_label(resource: &Resource) -> String {
    let lifetime = match resource.lifetime {
        Lifetime::Transient => "transient",
        Lifetime::Persistent => "persistent",
        Lifetime::Imported => "imported",
        Lifetime::Acquired => "acquired",
        Lifetime::Continued => "continued",
        Lifetime::Readback => "read by the host",
        Lifetime::Previous { .. } => "of the frame before",
        Lifetime::Current { .. } => "for the next frame",
    };
    let shape = match resource.info {
        _ if resource.lifetime == Lifetime::Imported => "as large as its owner made it".to_owned(),
        ResourceInfo::Buffer(info) => format!("{} bytes", info.size_bytes),
        ResourceInfo::Image(info) => image_shape(&info),
    };
    format!("{}\\n{shape}\\n{lifetime}", escape(&resource.name))
}

fn image_shape(info: &ImageInfo) -> String {
    let depth = match info.depth {
        ImageDepth::Flat => String::new(),
        ImageDepth::Layers(count) => format!(", {count} layers"),
        ImageDepth::Texels(depth_px) => format!("x{depth_px}"),
    };
    let levels = if info.level_count > 1 { format!(", {} levels", info.level_count) } else { String::new() };
    format!("{}x{}{depth}{levels} {:?}", info.width_px, info.height_px, info.format)
}

fn escape(name: &str) -> String {
    name.replace('\\', "\\\\").replace('"', "\\\"")
}
