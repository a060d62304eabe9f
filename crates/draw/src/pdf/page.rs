//! A drawing, read from SVG, as the content of a page.

use super::{POINTS, drawing, font::Font, path};
use pdf_writer::{Content, Name, Str};
use rijke_numerics::Failed;
use roxmltree::{Document, Node};
use std::collections::BTreeSet;

/// A page as it will be written.
pub(super) struct Page {
    /// Pixels.
    pub(super) size: [f64; 2],
    pub(super) title: String,
    pub(super) content: Vec<u8>,
    /// The upright and the italic face.
    pub(super) fonts: [Font; 2],
    /// Opacities of fillings, as the SVG has them; also the names of their states.
    pub(super) opacities: BTreeSet<String>,
}

/// What an element takes from those around it.
#[derive(Clone, Copy)]
struct Style<'a> {
    fill: &'a str,
    stroke: &'a str,
    size: f64,
    anchor: &'a str,
}

struct Writer {
    content: Content,
    fonts: [Font; 2],
    opacities: BTreeSet<String>,
}

pub(super) fn read(svg: &str) -> Result<Page, Failed> {
    let document = Document::parse(svg).map_err(|e| drawing(&e))?;
    let root = document.root_element();
    let size = [number(root, "width")?, number(root, "height")?];
    let title = root.children().find(|n| n.has_tag_name("title")).and_then(|n| n.text()).unwrap_or("");
    let mut writer = Writer { content: Content::new(), fonts: Font::both()?, opacities: BTreeSet::new() };
    // Pixels count downward.
    let scale = POINTS as f32;
    writer.content.transform([scale, 0.0, 0.0, -scale, 0.0, scale * size[1] as f32]);
    let style = Style { fill: "#000", stroke: "none", size: 16.0, anchor: "start" }.within(root)?;
    writer.children(root, style)?;
    let Writer { content, fonts, opacities } = writer;
    Ok(Page { size, title: title.to_owned(), content: content.finish().to_vec(), fonts, opacities })
}

impl Writer {
    fn children(&mut self, node: Node<'_, '_>, style: Style<'_>) -> Result<(), Failed> {
        node.children().filter(Node::is_element).try_for_each(|child| self.element(child, style))
    }

    fn element(&mut self, node: Node<'_, '_>, style: Style<'_>) -> Result<(), Failed> {
        let style = style.within(node)?;
        let of = |name| number(node, name);
        match node.tag_name().name() {
            "title" => {}
            "g" => {
                self.content.save_state();
                self.transform(node)?;
                self.children(node, style)?;
                self.content.restore_state();
            }
            "svg" => {
                let [x, y, width, height] =
                    [of("x")?, of("y")?, of("width")?, of("height")?].map(|v| v as f32);
                self.content.save_state().rect(x, y, width, height).clip_nonzero().end_path();
                self.content.transform([1.0, 0.0, 0.0, 1.0, x, y]);
                self.children(node, style)?;
                self.content.restore_state();
            }
            "rect" => self.shape(node, style, |content| {
                content.rect(0.0, 0.0, of("width")? as f32, of("height")? as f32);
                Ok(())
            })?,
            "path" => {
                self.shape(node, style, |content| path::add(node.attribute("d").unwrap_or(""), content))?
            }
            "circle" => self.shape(node, style, |content| {
                path::circle([of("cx")?, of("cy")?], of("r")?, content);
                Ok(())
            })?,
            "text" => {
                self.content.save_state();
                self.transform(node)?;
                self.text(node, style)?;
                self.content.restore_state();
            }
            other => return Err(drawing(&format!("the element {other}"))),
        }
        Ok(())
    }

    /// Fills and strokes what `draw` adds.
    fn shape(
        &mut self,
        node: Node<'_, '_>,
        style: Style<'_>,
        draw: impl FnOnce(&mut Content) -> Result<(), Failed>,
    ) -> Result<(), Failed> {
        let content = &mut self.content;
        content.save_state();
        if let Some([red, green, blue]) = colour(style.stroke)? {
            content
                .set_stroke_rgb(red, green, blue)
                .set_line_width(optional(node, "stroke-width", 1.0)? as f32);
            let dash = node.attribute("stroke-dasharray").unwrap_or("").split(' ').filter(|d| !d.is_empty());
            let dash: Result<Vec<f32>, _> = dash.map(str::parse).collect();
            content.set_dash_pattern(dash.map_err(|e| drawing(&e))?, 0.0);
        }
        if let Some([red, green, blue]) = colour(style.fill)? {
            content.set_fill_rgb(red, green, blue);
        }
        if let Some(opacity) = node.attribute("fill-opacity") {
            content.set_parameters(Name(opacity.as_bytes()));
            self.opacities.insert(opacity.to_owned());
        }
        draw(content)?;
        match (style.fill != "none", style.stroke != "none") {
            (true, true) => content.fill_nonzero_and_stroke(),
            (true, false) => content.fill_nonzero(),
            (false, true) => content.stroke(),
            (false, false) => content.end_path(),
        };
        content.restore_state();
        Ok(())
    }

    /// A line of text, each stretch in its own face and size. A stretch with a place of its own is anchored
    /// there, any other follows the one before it.
    fn text(&mut self, node: Node<'_, '_>, style: Style<'_>) -> Result<(), Failed> {
        let (mut x, mut y) = (optional(node, "x", 0.0)?, optional(node, "y", 0.0)?);
        let mut stretches = Vec::new();
        for child in node.children() {
            let style = style.within(child)?;
            if child.is_element() && !child.has_tag_name("tspan") {
                return Err(drawing(&format!("the element {} in a text", child.tag_name().name())));
            }
            let face = usize::from(child.attribute("font-style") == Some("italic"));
            let (letters, width) = self.fonts[face].set(child.text().unwrap_or(""));
            let wide = style.size * width;
            x = optional(child, "x", x)?
                - match style.anchor {
                    "middle" => 0.5 * wide,
                    "end" => wide,
                    _ => 0.0,
                };
            y = optional(child, "y", y)? + optional(child, "dy", 0.0)?;
            stretches.push((face, style.size, x, y, letters));
            x += wide;
        }
        if let Some([red, green, blue]) = colour(style.fill)? {
            self.content.set_fill_rgb(red, green, blue);
        }
        self.content.begin_text();
        for (face, size, x, y, letters) in stretches {
            self.content.set_font(Name(self.fonts[face].name()), size as f32);
            // Letters stand upright where pixels count downward.
            self.content.set_text_matrix([1.0, 0.0, 0.0, -1.0, x as f32, y as f32]);
            self.content.show(Str(&letters));
        }
        self.content.end_text();
        Ok(())
    }

    /// `translate(x y)`, and after it `rotate(degrees)`.
    fn transform(&mut self, node: Node<'_, '_>) -> Result<(), Failed> {
        for step in node.attribute("transform").unwrap_or("").split_inclusive(')') {
            let read = |n: &str| n.parse::<f32>().map_err(|e| drawing(&e));
            let (name, numbers) = step.trim().trim_end_matches(')').split_once('(').unwrap_or((step, ""));
            let numbers: Vec<f32> = numbers.split_whitespace().map(read).collect::<Result<_, _>>()?;
            match (name, &numbers[..]) {
                ("translate", [x, y]) => self.content.transform([1.0, 0.0, 0.0, 1.0, *x, *y]),
                ("rotate", [angle]) => {
                    let (sin, cos) = angle.to_radians().sin_cos();
                    self.content.transform([cos, sin, -sin, cos, 0.0, 0.0])
                }
                _ => return Err(drawing(&format!("the transform {step}"))),
            };
        }
        Ok(())
    }
}

impl<'a> Style<'a> {
    fn within(self, node: Node<'a, '_>) -> Result<Self, Failed> {
        if let Some(other) = node.attributes().find(|a| !KNOWN.contains(&a.name())) {
            return Err(drawing(&format!("the attribute {}", other.name())));
        }
        Ok(Self {
            fill: node.attribute("fill").unwrap_or(self.fill),
            stroke: node.attribute("stroke").unwrap_or(self.stroke),
            size: optional(node, "font-size", self.size)?,
            anchor: node.attribute("text-anchor").unwrap_or(self.anchor),
        })
    }
}

/// Attributes that are read, and after them those that do not matter on paper.
const KNOWN: [&str; 21] = [
    "cx",
    "cy",
    "d",
    "dy",
    "fill",
    "fill-opacity",
    "font-size",
    "font-style",
    "height",
    "r",
    "stroke",
    "stroke-dasharray",
    "stroke-width",
    "text-anchor",
    "transform",
    "width",
    "x",
    "y",
    "viewBox",
    "role",
    "font-family",
];

fn number(node: Node<'_, '_>, name: &str) -> Result<f64, Failed> {
    let text = node.attribute(name).unwrap_or("");
    text.parse().map_err(|_| drawing(&format!("{name}=\"{text}\" of {}", node.tag_name().name())))
}

fn optional(node: Node<'_, '_>, name: &str, usual: f64) -> Result<f64, Failed> {
    if node.has_attribute(name) { number(node, name) } else { Ok(usual) }
}

/// `#rgb` or `#rrggbb`; nothing for `none`.
fn colour(text: &str) -> Result<Option<[f32; 3]>, Failed> {
    let digits = text.strip_prefix('#').unwrap_or(text);
    let (long, most) = match digits.len() {
        _ if text == "none" => return Ok(None),
        3 => (1, 15.0),
        6 => (2, 255.0),
        _ => return Err(drawing(&format!("the colour {text}"))),
    };
    let part = |k: usize| digits.get(k * long..(k + 1) * long).and_then(|d| u8::from_str_radix(d, 16).ok());
    match [part(0), part(1), part(2)] {
        [Some(r), Some(g), Some(b)] => Ok(Some([r, g, b].map(|v| f32::from(v) / most))),
        _ => Err(drawing(&format!("the colour {text}"))),
    }
}
