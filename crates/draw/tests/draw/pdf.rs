//! Figures as PDF: what a reader of the format finds in the file, and that its font has the letters of
//! labels.

use flate2::read::ZlibDecoder;
use rijke_draw::{pdf, plot_svg};
use rijke_rig::{DataKind, Look, Plot, PlotCurve, PlotPanel};
use std::{io::Read as _, path::Path};

fn figure(panels: usize, label: &str) -> String {
    let curve = |name: &str, look| PlotCurve {
        name: name.into(),
        look,
        points: vec![[0.0, 1.0], [1.0, -1.0], [2.0, 0.5]],
    };
    let curves = vec![curve(label, Look::Record), curve("", Look::Dots(1)), curve("spread", Look::Patch(0))];
    let panel =
        PlotPanel { marks: vec![0.4], ..PlotPanel::new("*t* / s", "*\u{3c1}c u*_{0} / s^{-1}", curves) };
    plot_svg(&Plot { title: "Growth".into(), data: DataKind::Virtual, panels: vec![panel; panels] })
}

/// The bytes as text, and every packed stream opened.
fn opened(file: &[u8]) -> (String, Vec<Vec<u8>>) {
    let find =
        |from: usize, what: &[u8]| file[from..].windows(what.len()).position(|w| w == what).map(|k| from + k);
    let (mut at, mut streams) = (0, Vec::new());
    while let Some(start) = find(at, b"stream\n") {
        let mut stream = Vec::new();
        if ZlibDecoder::new(&file[start + 7..]).read_to_end(&mut stream).is_ok() {
            streams.push(stream);
        }
        at = find(start, b"endstream").map_or(file.len(), |end| end + 9);
    }
    (String::from_utf8_lossy(file).into_owned(), streams)
}

#[test]
fn behaviour_one_page_as_wide_as_columns_of_a_journal() {
    for (panels, millimetres) in [(1, 90.0), (2, 180.0), (3, 180.0)] {
        let file = pdf(&figure(panels, "record")).unwrap();
        let (text, streams) = opened(&file);
        assert!(text.starts_with("%PDF-1.7") && text.trim_end().ends_with("%%EOF"));
        assert!(text.contains("/Count 1") && text.contains("/Title (Growth (virtual data))"), "{text}");
        let page = text.split("/MediaBox [").nth(1).unwrap().split(']').next().unwrap();
        let sides: Vec<f64> = page.split(' ').map(|n| n.parse().unwrap()).collect();
        assert!((sides[2] / 72.0 * 25.4 - millimetres).abs() < 1e-3, "{page}");
        // Two faces, cut and embedded; no other font is named.
        assert_eq!([text.matches("/FontFile2 ").count(), text.matches("/BaseFont").count()], [2, 4]);
        assert_eq!(streams.iter().filter(|s| s.starts_with(&[0, 1, 0, 0])).count(), 2);
        assert!(!text.contains("Date") && !text.contains("/ID"), "the same figure, the same bytes");
        assert_eq!(file, pdf(&figure(panels, "record")).unwrap());
    }
}

/// The letters of the file, read back through its map of glyphs to characters, are the labels of the figure.
#[test]
fn oracle_the_text_can_be_copied() {
    let (text, streams) = opened(&pdf(&figure(1, "\u{c4}\u{3b1}")).unwrap());
    let maps: Vec<&str> =
        text.split("begincmap").skip(1).map(|m| m.split("endcmap").next().unwrap()).collect();
    let content = streams.iter().find(|s| s.windows(3).any(|w| w == b"BT\n")).unwrap();
    let said: String = maps
        .iter()
        .flat_map(|m| m.lines())
        .filter(|l| l.starts_with('<') && l.matches('<').count() == 2)
        .collect();
    for letter in ["00C4", "03B1", "03C1", "0074", "2212"] {
        assert!(said.contains(&format!("<{letter}>")), "{letter}: {said}");
    }
    assert!(content.windows(3).filter(|w| w == b" Tj").count() > 10);
}

#[test]
fn behaviour_a_letter_without_glyph_becomes_a_box() {
    let (known, unknown) = (pdf(&figure(1, "q")).unwrap(), pdf(&figure(1, "\u{6f22}")).unwrap());
    let shows = |file: &[u8]| {
        let (_, streams) = opened(file);
        streams.iter().any(|s| String::from_utf8_lossy(s).contains("(\\000\\000) Tj"))
    };
    assert!(shows(&unknown) && !shows(&known));
}

#[test]
fn message_what_this_crate_did_not_draw_is_refused() {
    let refused = |svg: &str| pdf(svg).unwrap_err().message;
    let of = |inside: &str| {
        refused(&format!("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"9\" height=\"9\">{inside}</svg>"))
    };
    assert_eq!(of("<image/>"), "not a drawing of rijke-draw: the element image");
    assert_eq!(of("<g opacity=\"0.1\"/>"), "not a drawing of rijke-draw: the attribute opacity");
    assert_eq!(
        of("<circle r=\"1\" cx=\"1\" cy=\"1\" fill=\"red\"/>"),
        "not a drawing of rijke-draw: the colour red"
    );
    assert!(
        of("<path d=\"M1 1Q2 2 3 3\"/>").contains("the path M1 1Q2")
            && refused("<svg").contains("not a drawing")
    );
}

/// Labels come from the examples' files and from the sources that write labels: their every character has a
/// glyph, upright and italic.
#[test]
fn behaviour_the_font_has_the_letters_of_all_examples() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let faces = [
        &include_bytes!("../../fonts/Arimo-Regular.ttf")[..],
        include_bytes!("../../fonts/Arimo-Italic.ttf"),
    ];
    let faces = faces.map(|bytes| ttf_parser::Face::parse(bytes, 0).unwrap());
    let (mut folders, mut files) = (
        vec![
            root.join("examples"),
            root.join("crates/report/src"),
            root.join("crates/draw/src"),
            root.join("crates/engine/src"),
        ],
        0,
    );
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() && !path.ends_with("results") {
                folders.push(path);
            } else if ["toml", "csv", "rs"].iter().any(|e| path.extension().is_some_and(|x| x == *e)) {
                files += 1;
                let text = std::fs::read_to_string(&path).unwrap();
                let lacks =
                    text.chars().find(|c| *c >= ' ' && faces.iter().any(|f| f.glyph_index(*c).is_none()));
                assert_eq!(lacks, None, "{}", path.display());
            }
        }
    }
    assert!(files > 100, "{files}");
}
