//! The bundled font: glyphs of a text, and the used ones embedded.

use super::{drawing, packed};
use crate::metrics::{ITALIC, REGULAR};
use pdf_writer::types::{CidFontType, FontFlags, SystemInfo, UnicodeCmap};
use pdf_writer::{Filter, Finish as _, Name, Pdf, Rect, Ref, Str};
use rijke_numerics::Failed;
use std::collections::BTreeMap;
use subsetter::GlyphRemapper;
use ttf_parser::{Face, GlyphId};

const INFO: SystemInfo = SystemInfo { registry: Str(b"Adobe"), ordering: Str(b"Identity"), supplement: 0 };

/// One face, and which of its glyphs were used.
pub(super) struct Font {
    name: &'static str,
    bytes: &'static [u8],
    face: Face<'static>,
    glyphs: GlyphRemapper,
    characters: BTreeMap<u16, char>,
}

impl Font {
    /// The upright and the italic face.
    pub(super) fn both() -> Result<[Self; 2], Failed> {
        let read = |name, bytes| -> Result<Self, Failed> {
            let face = Face::parse(bytes, 0).map_err(|e| drawing(&e))?;
            Ok(Self { name, bytes, face, glyphs: GlyphRemapper::new(), characters: BTreeMap::new() })
        };
        Ok([read("Arimo-Regular", REGULAR)?, read("Arimo-Italic", ITALIC)?])
    }

    pub(super) fn name(&self) -> &[u8] {
        self.name.as_bytes()
    }

    pub(super) fn is_used(&self) -> bool {
        self.glyphs.num_gids() > 1
    }

    /// A text as the file holds it, two bytes a glyph, and its width at size 1. The first glyph of the font,
    /// an empty box, stands for what it lacks.
    pub(super) fn set(&mut self, text: &str) -> (Vec<u8>, f64) {
        let (mut set, mut width) = (Vec::new(), 0.0);
        for letter in text.chars() {
            let glyph = self.face.glyph_index(letter).unwrap_or(GlyphId(0));
            let own = self.glyphs.remap(glyph.0);
            if own > 0 {
                self.characters.entry(own).or_insert(letter);
            }
            set.extend(own.to_be_bytes());
            width += self.per_mille(f64::from(self.face.glyph_hor_advance(glyph).unwrap_or(0))) / 1000.0;
        }
        (set, width)
    }

    /// The glyphs that were used, with their widths and characters, as objects from `next` on. Returns the
    /// object of the font.
    pub(super) fn embed(&self, file: &mut Pdf, next: &mut i32) -> Result<Ref, Failed> {
        let [font, cid, descriptor, data, unicode] = [0, 1, 2, 3, 4].map(|k| Ref::new(*next + k));
        *next += 5;
        let cut = subsetter::subset(self.bytes, 0, &self.glyphs).map_err(|e| drawing(&e))?;
        let name = format!("{}+{}", self.tag(), self.name);
        let name = Name(name.as_bytes());
        file.type0_font(font)
            .base_font(name)
            .encoding_predefined(Name(b"Identity-H"))
            .descendant_font(cid)
            .to_unicode(unicode);
        let advance = |glyph| f64::from(self.face.glyph_hor_advance(GlyphId(glyph)).unwrap_or(0));
        let mut written = file.cid_font(cid);
        written.subtype(CidFontType::Type2).base_font(name).system_info(INFO).font_descriptor(descriptor);
        written.cid_to_gid_map_predefined(Name(b"Identity"));
        let widths = self.glyphs.remapped_gids().map(|g| self.per_mille(advance(g)) as f32);
        written.widths().consecutive(0, widths);
        written.finish();
        let flags = FontFlags::NON_SYMBOLIC;
        let italic = self.face.italic_angle();
        let [ascent, descent, height] =
            [self.face.ascender(), self.face.descender(), self.face.capital_height().unwrap_or(0)]
                .map(|v| self.per_mille(f64::from(v)) as f32);
        let bounds = self.face.global_bounding_box();
        let [left, low, right, high] = [bounds.x_min, bounds.y_min, bounds.x_max, bounds.y_max]
            .map(|v| self.per_mille(f64::from(v)) as f32);
        file.font_descriptor(descriptor)
            .name(name)
            .flags(if italic == 0.0 { flags } else { flags | FontFlags::ITALIC })
            .bbox(Rect::new(left, low, right, high))
            .italic_angle(italic)
            .ascent(ascent)
            .descent(descent)
            .cap_height(height)
            .stem_v(STEM)
            .font_file2(data);
        file.stream(data, &packed(&cut)?)
            .filter(Filter::FlateDecode)
            .pair(Name(b"Length1"), cut.len() as i32);
        let mut map = UnicodeCmap::new(Name(b"Letters"), INFO);
        self.characters.iter().for_each(|(glyph, letter)| map.pair(*glyph, *letter));
        file.cmap(unicode, &map.finish());
        Ok(font)
    }

    /// Six letters by which programs tell different cuts of one font apart: digits of a hash of the glyphs.
    fn tag(&self) -> String {
        let hash =
            self.glyphs.remapped_gids().fold(0_u32, |hash, glyph| hash.wrapping_mul(31) ^ u32::from(glyph));
        (0..6).map(|k| char::from(b'A' + (hash / 26_u32.pow(k) % 26) as u8)).collect()
    }

    fn per_mille(&self, units: f64) -> f64 {
        1000.0 * units / f64::from(self.face.units_per_em())
    }
}

/// Thickness of an upright stem of Arimo, in thousandths of its size.
const STEM: f32 = 88.0;
