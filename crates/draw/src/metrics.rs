//! The bundled font: its bytes, and how wide its letters are. They have the widths of Arial and Helvetica,
//! which the SVG files name.

use std::sync::OnceLock;
use ttf_parser::{Face, FaceParsingError, GlyphId};

/// Arimo, cut to the characters of labels; `crates/draw/fonts/README.md` says how.
pub(crate) const REGULAR: &[u8] = include_bytes!("../fonts/Arimo-Regular.ttf");
pub(crate) const ITALIC: &[u8] = include_bytes!("../fonts/Arimo-Italic.ttf");

/// Width of a text in the upright or the italic face at size 1. A letter that the font lacks is as wide as
/// its empty box.
pub(crate) fn advance(text: &str, italic: bool) -> f64 {
    static FACES: [OnceLock<Result<Face<'static>, FaceParsingError>>; 2] = [OnceLock::new(), OnceLock::new()];
    let read = || Face::parse(if italic { ITALIC } else { REGULAR }, 0);
    let Ok(face) = FACES[usize::from(italic)].get_or_init(read) else { return 0.53 * text.len() as f64 };
    let wide = |letter: char| {
        let glyph = face.glyph_index(letter).unwrap_or(GlyphId(0));
        f64::from(face.glyph_hor_advance(glyph).unwrap_or(0))
    };
    text.chars().map(wide).sum::<f64>() / f64::from(face.units_per_em())
}

#[cfg(test)]
mod tests {
    use super::advance;

    #[test]
    fn exact_letters_have_the_widths_of_helvetica() {
        // Of a thousand: a 556, space and i 278 and 222, true minus 584.
        for (text, width) in [("a", 0.556), (" ", 0.278), ("i", 0.222), ("\u{2212}", 0.584)] {
            assert!((advance(text, false) - width).abs() < 1e-3, "{text}: {}", advance(text, false));
        }
        assert!((advance("aa", true) - 1.112).abs() < 2e-3);
    }
}
