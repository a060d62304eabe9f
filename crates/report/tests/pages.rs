//! Reports from hand-made numbers: what any report must be, whatever the numbers.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

mod sample;

use rijke_report::{Numbers, Report, ReportError};
use rijke_studies::Evidence;
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
    let figures: Vec<_> =
        names.iter().filter_map(|n| n.strip_prefix("figures/")?.strip_suffix(".svg")).collect();
    let numbered = ["2", "3", "4", "5", "6", "7", "8", "9", "10", "11", "12"].map(|n| format!("figure-{n}"));
    assert_eq!(figures, numbered.iter().map(|n| &**n).chain(["lumped"]).collect::<Vec<_>>());
    for table in [
        "table-1",
        "table-2",
        "table-2-parameters",
        "table-4",
        "figure-6",
        "figure-11",
        "consistency",
        "truths",
    ] {
        assert!(names.contains(&&*format!("tables/{table}.csv")), "{table} is missing in {names:?}");
    }
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

/// What stands in the row of the overview for an item.
fn overview<'a>(page: &'a str, what: &str) -> &'a str {
    let row = page.split("<tr>").skip(1).find(|row| row.contains(what));
    row.unwrap_or_else(|| unreachable!("the overview lacks {what}"))
}

#[test]
fn exact_the_overview_says_how_each_item_compares() {
    let report = Report::new(&sample::numbers()).unwrap();
    let page = String::from_utf8_lossy(&report.files().last().unwrap().1).into_owned();
    // eta = 1.6 against 1.67; a winner that is not the paper's; evidence of other data.
    assert!(overview(&page, "wall-loss factor that makes up").contains(">agrees<"));
    assert!(
        overview(&page, "Table 4").contains("model 9 (") && overview(&page, "Table 4").contains(">differs<")
    );
    // Two models within a nat of each other.
    let lead = page.split("<li>").find(|li| li.contains("It leads the paper's by")).unwrap();
    assert!(lead.contains("by 105.0 nats in all."), "{lead}");
    let mut close = sample::numbers();
    let models = &mut close.heat_release.as_mut().unwrap().models;
    models[7].evidence = models[8].evidence.map(|e| Evidence { ln_marginal: e.ln_marginal - 0.02, ..e });
    let report = Report::new(&close).unwrap();
    let close = String::from_utf8_lossy(&report.files().last().unwrap().1).into_owned();
    assert!(
        overview(&close, "Table 4").contains(">not decided<")
            && close.contains("by 2.1 nats in all, so these data")
    );
    assert!(overview(&page, "ln ML of that model").contains(">cannot be compared<"));
    // The jump of the angle is in the naive figure only.
    assert!(overview(&page, "lag below and above").contains("means differ by 1.2"));
    assert!(overview(&page, "lag of the heat release, same points").contains(">agrees<"));
}

#[test]
fn exact_the_header_counts_the_whole_campaign() {
    let mut numbers = sample::numbers();
    numbers.campaign.as_mut().unwrap().provenance.points = 175;
    numbers.campaign.as_mut().unwrap().provenance.rejected = vec![];
    let report = Report::new(&numbers).unwrap();
    let page = String::from_utf8_lossy(&report.files().last().unwrap().1).into_owned();
    assert!(page.contains("175 operating points, 797 pings used,\n0 records not used"), "{page}");
}

#[test]
fn exact_the_page_needs_nothing_else() {
    let report = Report::new(&sample::numbers()).unwrap();
    let page = String::from_utf8_lossy(&report.files().last().unwrap().1);
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
    macro_rules! save_as_json {
        ($($field:ident)*) => {
            $(save(concat!(stringify!($field), ".json"), serde_json::to_string(&numbers.$field).unwrap());)*
        };
    }
    save_as_json!(campaign flow empty_tube prongs cold feedback feedback_naive heat_release microphones consistency
        lumped_convergence truths);
    for (study, number) in numbers.predictions.iter().zip(8..) {
        save(&format!("figure_{number}.json"), serde_json::to_string(study).unwrap());
    }
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
    let page = String::from_utf8_lossy(&report.files().last().unwrap().1);
    assert!(!page.contains("<script") && !page.contains("<b>&"));
}
