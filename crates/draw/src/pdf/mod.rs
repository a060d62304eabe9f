//! The figures of this crate as PDF: read from their SVG, so that one drawing serves both. Knows no figure.
//! What the SVG may hold is the little that [`crate::Figure`] writes; anything else is refused. Why not a
//! general converter: `docs/decisions/figures.md`.

mod font;
mod page;
mod path;

use flate2::{Compression, write::ZlibEncoder};
use font::Font;
use pdf_writer::{Filter, Finish as _, Name, Pdf, Rect, Ref, TextStr};
use rijke_numerics::Failed;
use std::io::Write as _;

/// Points of a pixel: a panel, 430 pixels wide, becomes a column of a journal, 90 mm.
const POINTS: f64 = 90.0 / 25.4 * 72.0 / crate::COLUMN;

const CATALOG: Ref = Ref::new(1);
const PAGES: Ref = Ref::new(2);
const PAGE: Ref = Ref::new(3);
const CONTENT: Ref = Ref::new(4);
const INFO: Ref = Ref::new(5);
/// Fonts and opacities come from here on.
const FIRST_FREE: i32 = 6;

/// A figure of this crate, given as the text of its SVG file, as a PDF file of one page: 90 mm wide if it has
/// one column of panels, 180 mm with two. Letters are those of Arimo, embedded; a character that Arimo lacks
/// becomes an empty box. The same figure gives the same bytes.
///
/// # Errors
/// If the SVG was not written by this crate.
pub fn pdf(svg: &str) -> Result<Vec<u8>, Failed> {
    let page = page::read(svg)?;
    let [width, height] = page.size.map(|v| (v * POINTS) as f32);
    let mut file = Pdf::new();
    file.catalog(CATALOG).pages(PAGES);
    file.pages(PAGES).kids([PAGE]).count(1);
    file.document_info(INFO).title(TextStr(&page.title)).producer(TextStr("rijke"));
    let mut next = FIRST_FREE;
    let mut fonts: Vec<(&Font, Ref)> = Vec::new();
    for font in page.fonts.iter().filter(|f| f.is_used()) {
        fonts.push((font, font.embed(&mut file, &mut next)?));
    }
    let states: Vec<(&String, Ref)> =
        page.opacities.iter().zip(next..).map(|(o, k)| (o, Ref::new(k))).collect();
    for (opacity, at) in &states {
        file.ext_graphics(*at).non_stroking_alpha(opacity.parse().unwrap_or(1.0));
    }
    let mut sheet = file.page(PAGE);
    sheet.parent(PAGES).media_box(Rect::new(0.0, 0.0, width, height)).contents(CONTENT);
    let mut resources = sheet.resources();
    resources.fonts().pairs(fonts.iter().map(|(font, at)| (Name(font.name()), *at)));
    resources.ext_g_states().pairs(states.iter().map(|(opacity, at)| (Name(opacity.as_bytes()), *at)));
    resources.finish();
    sheet.finish();
    file.stream(CONTENT, &packed(&page.content)?).filter(Filter::FlateDecode);
    Ok(file.finish())
}

fn packed(bytes: &[u8]) -> Result<Vec<u8>, Failed> {
    let mut packer = ZlibEncoder::new(Vec::new(), Compression::best());
    packer.write_all(bytes).and_then(|()| packer.finish()).map_err(|e| drawing(&e))
}

/// What cannot be read as a drawing of this crate.
fn drawing(why: &impl std::fmt::Display) -> Failed {
    Failed::of_work(format!("not a drawing of rijke-draw: {why}"))
}
