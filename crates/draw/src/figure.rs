//! Figures: panels, a legend and the statement where the data come from.

use super::{DOT, INK, Panel, Stroke, Symbol, px, text};
use rijke_rig::DataKind;

const FONT: &str = "'Helvetica Neue', Helvetica, Arial, 'Liberation Sans', 'DejaVu Sans', sans-serif";

/// Font size and line height of legends, pixels.
const LEGEND: f64 = 12.5;
const LINE: f64 = 20.0;
/// Room for the mark of an entry, and between entries.
const MARK: f64 = 30.0;
const GAP: f64 = 18.0;

/// A figure. On a page its panels flow to fit the window; as a file they stand in rows of `columns`.
pub struct Figure {
    /// What it shows, in one line.
    pub title: String,
    /// Caption as a reader of the paper expects it, in the markup of labels.
    pub caption: String,
    /// Panels in one row of the file.
    pub columns: usize,
    /// The panels, in reading order, of equal size.
    pub panels: Vec<Panel>,
    /// The legend.
    pub legend: Vec<Key>,
    /// Whether measured, virtual or no data are shown: stands on every panel.
    pub data: Option<DataKind>,
}

/// An entry of a legend.
pub struct Key {
    /// What is drawn.
    pub mark: Mark,
    /// What it means.
    pub label: String,
}

/// A sample of what is drawn.
pub enum Mark {
    /// A line.
    Line(Stroke),
    /// A dot of this colour.
    Dot(&'static str),
    /// A filled symbol of this colour.
    Point(Symbol, &'static str),
    /// A short horizontal line, as a prediction at one place is drawn.
    Dash(Stroke),
    /// The same through an open symbol.
    DashedRing(Stroke),
    /// A dot of this colour with a vertical bar.
    Bar(&'static str),
    /// A patch of this colour.
    Patch(&'static str),
    /// A diagonal cross.
    Cross(Stroke),
}

impl Figure {
    /// The figure as an SVG file of its own.
    pub fn svg(&self) -> String {
        let (cell_width, cell_height) = self.cell();
        let width = cell_width * self.columns as f64;
        let columns = self.columns.max(1);
        let rows = self.panels.len().div_ceil(columns);
        let mut body = String::new();
        for (i, panel) in self.panels.iter().enumerate() {
            let (row, column) = (i / columns, i % columns);
            let (x, y) = (px(column as f64 * cell_width), px(row as f64 * cell_height));
            body += &format!("<g transform=\"translate({x} {y})\">{}</g>", panel.elements(self.note()));
        }
        let mut cursor = [16.0, rows as f64 * cell_height + LINE];
        for key in &self.legend {
            let lines = text::wrapped(&key.label, LEGEND, width - 16.0 - MARK);
            let longest = lines.iter().map(|line| text::width(line, LEGEND)).fold(0.0, f64::max);
            let wide = MARK + longest + GAP;
            if cursor[0] > 16.0 && cursor[0] + wide > width {
                cursor = [16.0, cursor[1] + LINE];
            }
            let (x, y) = (px(cursor[0]), px(cursor[1] - 0.35 * LEGEND));
            body += &format!("<g transform=\"translate({x} {y})\">{}</g>", key.mark.elements());
            for (k, line) in lines.iter().enumerate() {
                cursor[1] += if k > 0 { LINE } else { 0.0 };
                body +=
                    &text::element([cursor[0] + MARK, cursor[1]], false, "start", LEGEND, line.trim_end());
            }
            cursor[0] += wide;
        }
        self.document([width, cursor[1] + 12.0], &self.title, &body)
    }

    /// The figure as HTML whose panels flow.
    pub fn html(&self) -> String {
        // What the style of the page says of all figures is left out of each.
        let usual = format!(" r=\"{}\"", px(DOT));
        let document = |panel: &Panel| {
            let body = panel.elements(self.note()).replace(&usual, "");
            let [w, h] = [panel.width, panel.height].map(px);
            let title = self.full_title(&self.title);
            format!(
                "<svg viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" role=\"img\"><title>{title}</title>{body}</svg>"
            )
        };
        let panels: String = self.panels.iter().map(|p| format!("<div>{}</div>", document(p))).collect();
        let key = |key: &Key| {
            let mark = key.mark.elements();
            let label = text::html(&key.label);
            format!(
                "<span class=\"key\"><svg viewBox=\"0 -8 26 16\" width=\"26\" height=\"16\" aria-hidden=\"true\">\
                 {mark}</svg>{label}</span> "
            )
        };
        let legend: String = self.legend.iter().map(key).collect();
        format!(
            "<div class=\"panels columns-{}\">{panels}</div>\n<div class=\"legend\">{legend}</div>",
            self.columns
        )
    }

    /// What stands on every panel.
    pub fn note(&self) -> &'static str {
        match self.data {
            Some(DataKind::Virtual) => "virtual data",
            Some(DataKind::Measured) => "measured data",
            None => "computed, no data",
        }
    }

    fn cell(&self) -> (f64, f64) {
        self.panels.first().map_or((0.0, 0.0), |p| (p.width, p.height))
    }

    fn full_title(&self, title: &str) -> String {
        text::escape(&format!("{} ({})", text::plain(title), self.note()))
    }

    fn document(&self, [width, height]: [f64; 2], title: &str, body: &str) -> String {
        let (w, h) = (px(width), px(height));
        let title = self.full_title(title);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" role=\"img\" \
             font-family=\"{FONT}\" fill=\"{INK}\"><title>{title}</title>\
             <rect width=\"{w}\" height=\"{h}\" fill=\"#fff\"/>{body}</svg>"
        )
    }
}

impl Mark {
    /// The mark, 26 pixels wide, centred on the line y = 0.
    fn elements(&self) -> String {
        match self {
            Self::Line(stroke) => format!("<path d=\"M1 0H25\" fill=\"none\" {}/>", stroke.attributes()),
            Self::Dot(colour) => format!("<circle cx=\"13\" cy=\"0\" r=\"3.2\" fill=\"{colour}\"/>"),
            Self::Point(symbol, colour) => {
                format!("<path d=\"{}\" fill=\"{colour}\"/>", symbol.outline([13.0, 0.0], 3.2))
            }
            Self::Dash(stroke) => format!("<path d=\"M8.5 0H17.5\" fill=\"none\" {}/>", stroke.attributes()),
            Self::DashedRing(stroke) => {
                let ring = Symbol::Dot.outline([13.0, 0.0], 4.0);
                format!("<path d=\"M5.5 0H20.5{ring}\" fill=\"none\" {}/>", stroke.attributes())
            }
            Self::Bar(colour) => format!(
                "<path d=\"M13 -8V8\" fill=\"none\" {}/><circle cx=\"13\" cy=\"0\" r=\"{}\" fill=\"{colour}\"/>",
                Stroke::solid(colour, 1.0).attributes(),
                px(DOT)
            ),
            Self::Patch(colour) => {
                format!("<path d=\"M1 -5H25V5H1Z\" fill=\"{colour}\" fill-opacity=\"0.2\"/>")
            }
            Self::Cross(stroke) => {
                format!("<path d=\"M8 -5L18 5M8 5L18 -5\" fill=\"none\" {}/>", stroke.attributes())
            }
        }
    }
}
