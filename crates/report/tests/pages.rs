//! Reports from hand-made numbers: what any report must be, whatever the numbers.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

mod sample;

use rijke_report::{Numbers, Report, ReportError};
use std::{fs, path::PathBuf};

fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn exact_files_are_those_of_the_studies() {
    let report = Report::new(&sample::numbers()).unwrap();
    let names: Vec<_> = report.files().iter().map(|(name, _)| &**name).collect();
    assert_eq!(
        names,
        [
            "index.html",
            "figures/figure-3.svg",
            "tables/figure-3.csv",
            "figures/figure-4.svg",
            "tables/figure-4.csv",
            "tables/table-2.csv",
            "tables/table-2-parameters.csv",
            "figures/figure-12.svg",
            "tables/consistency.csv",
            "figures/lumped.svg",
            "tables/lumped.csv",
        ]
    );
}

#[test]
fn exact_every_panel_says_that_its_data_are_virtual() {
    let report = Report::new(&sample::numbers()).unwrap();
    for (name, content) in report.files().iter().filter(|(name, _)| name.ends_with(".svg")) {
        let text = String::from_utf8_lossy(content);
        // Panels are the nested svg elements.
        let (panels, notes) = (text.matches("<svg x=").count(), text.matches(">virtual data<").count());
        let notes = notes + text.matches(">computed, no data<").count();
        assert!(panels > 0 && panels == notes, "{name}: {panels} panels, {notes} notes");
    }
}

#[test]
fn exact_the_page_needs_nothing_else() {
    let report = Report::new(&sample::numbers()).unwrap();
    let page = String::from_utf8_lossy(&report.files()[0].1);
    let addresses = page.matches("http").count();
    assert_eq!(addresses, page.matches("xmlns=\"http://www.w3.org/2000/svg\"").count());
    for tag in ["<script", "<img", "<iframe", "@import", "url("] {
        assert!(!page.contains(tag), "{tag}");
    }
}

#[test]
fn exact_same_numbers_same_bytes_also_through_files() {
    let numbers = sample::numbers();
    let folder = folder("same-bytes");
    let save = |name: &str, text: String| fs::write(folder.join(name), text).unwrap();
    save("empty_tube.json", serde_json::to_string(&numbers.empty_tube).unwrap());
    save("microphones.json", serde_json::to_string(&numbers.microphones).unwrap());
    save("prongs.json", serde_json::to_string(&numbers.prongs).unwrap());
    save("consistency.json", serde_json::to_string(&numbers.consistency).unwrap());
    save("lumped_convergence.json", serde_json::to_string(&numbers.lumped_convergence).unwrap());
    let again = Numbers::read(&folder).unwrap();
    assert!(again == numbers, "the files do not give the numbers back");
    assert!(Report::new(&again).unwrap() == Report::new(&numbers).unwrap());
    Report::new(&again).unwrap().write(&folder).unwrap();
    assert!(folder.join("figures/figure-4.svg").is_file() && !folder.join("index.partial").exists());
}

#[test]
fn exact_numbers_that_cannot_be_drawn_name_the_place() {
    assert!(matches!(Report::new(&Numbers::default()), Err(ReportError::Nothing)));
    let folder = folder("malformed");
    fs::write(folder.join("prongs.json"), "{\n  \"provenance\": 3\n}").unwrap();
    let message = Numbers::read(&folder).unwrap_err().to_string();
    assert!(message.contains("prongs.json: line 2, column 17"), "{message}");
    let message = Numbers::read(&folder.join("absent")).unwrap_err().to_string();
    assert!(message.contains("absent"), "{message}");
}

#[test]
fn exact_text_from_records_cannot_break_the_page() {
    let mut numbers = sample::numbers();
    let provenance = &mut numbers.prongs.as_mut().unwrap().provenance;
    provenance.rejected[0].reason = "<script>alert(1)</script>".to_owned();
    numbers.empty_tube.as_mut().unwrap().provenance.rig = "<b>&".to_owned();
    let report = Report::new(&numbers).unwrap();
    let page = String::from_utf8_lossy(&report.files()[0].1);
    assert!(!page.contains("<script") && !page.contains("<b>&"));
}
