//! Films side by side, and below them their part with the most detail.

use super::detail::busiest;
use super::panels::{Panel, Picture, zoom};
use super::report::Report;
use super::{Findings, work};
use crate::Result;

/// Pictures of the first seed of every variant, beside what they should be.
pub fn write(report: &mut Report, name: &str, findings: &Findings, scene: &str, variants: &[&str]) -> Result<()> {
    let Some(reference) = findings.reference(scene) else { return Ok(()) };
    let mut pictures = Vec::new();
    for variant in variants {
        if let Some(first) = findings.of(Some(scene), variant).next() {
            pictures.extend(work::image(first)?.image("").map(|image| (*variant, Picture::of(&image))));
        }
    }
    pictures.push(("reference", Picture::of(&reference.image)));
    let window = busiest(&reference.image);
    let films = pictures.iter().map(|(caption, picture)| {
        let zoom = zoom(picture.width);
        let outlined = window.map(|side| side * zoom);
        Panel { caption: (*caption).into(), picture: picture.enlarge(zoom).outline(outlined) }
    });
    let parts = pictures
        .iter()
        .map(|(_, picture)| Panel { caption: String::new(), picture: picture.crop(window).enlarge(zoom(window[2])) });
    let rows = [films.collect(), parts.collect()];
    report.pictures(name, &rows, "First seed; below, the part with the most detail in the reference.")
}
