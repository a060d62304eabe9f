//! `rijke process --plot` writes a page and the pictures that it names.

use crate::{rijke, scratch};
use std::fs;

#[test]
fn exact_the_page_names_every_picture_and_every_picture_has_its_panels() {
    let folder = scratch("plots");
    let campaign = "name = \"one\"\n[[row]]\nid = \"C3\"\nplates = false\nthermometers = false\npower_w = 0.0\nrepeats = 2\n\
                    positions_cm = [85]\n";
    fs::write(folder.join("campaign.toml"), campaign).unwrap();
    let words = "process --virtual-rig --campaign campaign.toml --plot --out out";
    let output = rijke(&folder, &words.split(' ').collect::<Vec<_>>());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let plots = folder.join("out/plots");
    let page = fs::read_to_string(plots.join("index.html")).unwrap();
    let named: Vec<&str> = page.split('"').filter(|text| text.ends_with(".svg")).collect();
    assert_eq!(named, ["delays.svg", "C3-85/ping-00.wav.svg", "C3-85/click-00.wav.svg"], "{page}");
    for (name, panels) in named.iter().zip(["(a)(b)", "(a)(b)(c)(d)", "(a)(b)"]) {
        let picture = fs::read_to_string(plots.join(name)).unwrap();
        let pdf = fs::read(plots.join(name.replace(".svg", ".pdf"))).unwrap();
        assert_eq!(pdf, rijke_draw::pdf(&picture).unwrap(), "{name}");
        assert!(picture.starts_with("<svg") && picture.trim_end().ends_with("</svg>"), "{name}");
        for panel in panels.split_inclusive(')') {
            assert!(picture.contains(panel), "{name}: no panel {panel}");
        }
        assert!(picture.contains("virtual data"), "{name} does not say where its data come from");
        assert!(!picture.contains("NaN") && !picture.contains("inf"), "{name}");
    }
    let click = fs::read_to_string(plots.join(named[2])).unwrap();
    assert!(
        click.contains(">p8<") && !click.contains(">p0<") && click.contains("Residual / Pa"),
        "a click's picture names the microphones and shows what is left"
    );
    let delays = fs::read_to_string(plots.join("delays.svg")).unwrap();
    for m in 1..=8 {
        assert_eq!(delays.matches(&format!(">p{m}<")).count(), 2, "p{m} stands below both panels: {delays}");
    }
    assert!(delays.contains("relative to p1 / \u{b5}s"), "{delays}");
    // Pings and clicks have colours of their own.
    let colour = |name: &str| {
        let key = delays.split(&format!(">{name}, ")).next().unwrap();
        key.rsplit("fill=\"#").next().unwrap()[..6].to_owned()
    };
    assert_ne!(colour("pings"), colour("clicks"));
}
