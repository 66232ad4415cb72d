//! The report as one HTML page: no scripts, no fonts, nothing fetched.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::pictures::{Picture, StagePictures};
use super::{ErrorReport, INTERRUPTED, Side, Stage, measure, time};
use crate::Result;

const STYLE: &str = include_str!("style.css");

/// The whole page.
pub fn page(report: &ErrorReport) -> Result<String> {
    let title = format!("Error report: {}", report.scene.name);
    let stages = report.stages.iter().enumerate();
    let sections = stages.map(|(index, stage)| section(index, stage, report.exposure)).collect::<Result<Vec<_>>>()?;
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header { h1 { (title) } (facts(report)) }
                @if report.interrupted { p.warning role="status" { (INTERRUPTED) } }
                nav { (summary(&report.stages)) }
                main { @for section in &sections { (section) } }
                footer { (legend()) }
            }
        }
    };
    Ok(page.into_string())
}

fn facts(report: &ErrorReport) -> Markup {
    html! {
        dl { @for (name, value) in report.facts() { div { dt { (name) } dd { (value) } } } }
    }
}

/// The table that leads to the stages.
fn summary(stages: &[Stage]) -> Markup {
    html! {
        table {
            thead { tr {
                @for name in ["stage", "what differs"] { th { (name) } }
                @for name in ["energy ratio", "relMSE", "relMSE of 8x8 blocks", "FLIP", "reference", "test"] {
                    th.number { (name) }
                }
            } }
            tbody { @for (index, stage) in stages.iter().enumerate() { tr {
                td { a href={ "#" (anchor(index)) } { (stage.name) } }
                td { (stage.cause) }
                @let metrics = &stage.metrics;
                @for value in [metrics.energy_ratio, metrics.relmse, metrics.smooth_relmse, Some(metrics.flip)] {
                    td.number { (measure(value)) }
                }
                @for side in [&stage.reference, &stage.test] { td.number { (time(side.ms)) } }
            } } }
        }
    }
}

fn anchor(index: usize) -> String {
    format!("stage-{}", index + 1)
}

fn section(index: usize, stage: &Stage, exposure: f64) -> Result<Markup> {
    let pictures = StagePictures::new(&stage.images, exposure);
    let figures = [
        (
            "reference",
            format!("Reference: {}", side(&stage.reference)),
            figure_image(&pictures.reference, "reference")?,
        ),
        ("test", format!("Test: {}", side(&stage.test)), figure_image(&pictures.test, "test")?),
        (
            "difference",
            "Relative difference: blue where the test is darker, red where it is brighter".to_owned(),
            figure_image(&pictures.difference, "relative difference")?,
        ),
        ("flip", "FLIP: what the eye sees change".to_owned(), figure_image(&pictures.flip, "FLIP error")?),
    ];
    Ok(html! {
        section id=(anchor(index)) {
            h2 { (stage.name) }
            p { (stage.cause) }
            (numbers(stage))
            @let remarks = stage.remarks();
            @if !remarks.is_empty() { ul.notes { @for remark in &remarks { li { (remark) } } } }
            (switch(index))
            div.figures {
                @for (class, caption, image) in &figures {
                    figure class=(class) { (image) figcaption { (caption) } }
                }
            }
            p { a href="#" { "to the top" } }
        }
    })
}

/// Chooses what is seen: both pictures, or one of them in the same place. Siblings of the figures, so that CSS sees them.
fn switch(index: usize) -> Markup {
    let (group, id) = (format!("shown-{}", index + 1), |class: &str| format!("{class}-{}", index + 1));
    html! {
        @for (class, label) in [("both", "both"), ("only-reference", "reference"), ("only-test", "test")] {
            input type="radio" name=(group) id=(id(class)) class=(class) checked[class == "both"];
            label for=(id(class)) { (label) }
        }
    }
}

fn figure_image(picture: &Picture, what: &str) -> Result<Markup> {
    let url = picture.to_url()?;
    Ok(html! { img src=(url) width=(picture.width) height=(picture.height) alt=(what); })
}

fn side(side: &Side) -> String {
    side.ms.map_or_else(|| side.label.clone(), |ms| format!("{}, {}", side.label, time(Some(ms))))
}

fn numbers(stage: &Stage) -> Markup {
    let metrics = &stage.metrics;
    let [red, green, blue] = metrics.energy_ratio_rgb.map(measure);
    let decibels = metrics.psnr_db.map_or_else(|| "no difference".to_owned(), |db| format!("{db:.2} dB"));
    let mut rows = vec![
        ("energy ratio", measure(metrics.energy_ratio)),
        ("energy ratio R, G, B", format!("{red}, {green}, {blue}")),
        ("relMSE", measure(metrics.relmse)),
        ("relMSE of 8x8 blocks", measure(metrics.smooth_relmse)),
        ("highest ratio of 20x20 blocks", measure(metrics.highest_block_ratio)),
        ("RMSE", measure(Some(metrics.rmse))),
        ("PSNR", decibels),
        ("SSIM", measure(metrics.ssim)),
        ("FLIP", measure(Some(metrics.flip))),
    ];
    if let Some(indirect) = &metrics.indirect {
        rows.push(("indirect energy ratio", measure(indirect.indirect_ratio)));
        rows.push(("indirect relMSE of blocks", measure(indirect.indirect_smooth_relmse)));
    }
    html! { dl { @for (name, value) in &rows { div { dt { (name) } dd { (value) } } } } }
}

fn legend() -> Markup {
    html! {
        p {
            "Pictures are shown with one exposure, Reinhard's tone mapping and sRGB. Magenta marks pixels that are NaN or "
            "infinite; they are in no measure. The difference is (test - reference) / (reference + a tenth of its mean), of "
            "the mean of the channels. relMSE of 8x8 blocks hardly sees noise, so it shows bias."
        }
    }
}
