//! No input makes a reader panic, and every complaint about an element says which: random text, files broken
//! at random, and files whose numbers are replaced by hostile ones and which are then solved.

use proptest::prelude::*;
use rijke_network::file::{FileError, OscilosTexts, read, read_oscilos};
use rijke_network::{Chain, Constant, Workspace};
use rijke_numerics::Streams;

const FILES: [&str; 4] = [
    include_str!("../../../../fixtures/networks/rig-tube.toml"),
    include_str!("../../../../fixtures/networks/rijke-tube.toml"),
    include_str!("../../../../fixtures/networks/combustor.toml"),
    include_str!("../../../../fixtures/networks/combustor-flow.toml"),
];

/// What breaks programs that read numbers.
const NUMBERS: [&str; 16] = [
    "0",
    "-0.0",
    "-1",
    "1e308",
    "1e-308",
    "nan",
    "inf",
    "-inf",
    "1e20",
    "9223372036854775807",
    "0.3",
    "1e-9",
    "[]",
    "[1, 2]",
    "'text'",
    "true",
];

/// A file with one to three of its values replaced.
fn mutated(seed: u64) -> String {
    use rand::RngExt;
    let mut rng = Streams::new(seed).stream("network/fuzz");
    let mut draw = |n: usize| (rng.random::<f64>() * n as f64) as usize;
    let mut lines: Vec<String> = FILES[draw(FILES.len())].lines().map(str::to_owned).collect();
    for _ in 0..=draw(3) {
        let at = draw(lines.len());
        let number = NUMBERS[draw(NUMBERS.len())];
        match draw(5) {
            0 => {
                lines.remove(at);
            }
            1 => lines.insert(at, lines[draw(lines.len())].clone()),
            _ => {
                if let Some((key, _)) = lines[at].clone().split_once('=') {
                    lines[at] = format!("{key}= {number}");
                }
            }
        }
    }
    lines.join("\n")
}

/// Reads a text, and solves what it describes if that is small enough to be quick.
fn read_and_solve(text: &str) {
    match read(text) {
        Err(FileError::Element { line, place, .. }) => {
            assert!(line >= 1 && line <= text.lines().count() + 1, "{place}");
            let known = ["element ", "[upstream]", "[downstream]", "[gas]"];
            assert!(known.iter().any(|k| place.starts_with(k)), "{place}");
        }
        Err(_) => {}
        Ok(built) => {
            if built.network.segments().len() > 500 {
                return;
            }
            let mut work = Workspace::default();
            let modes = built.modes(&built.region);
            for mode in modes.iter().flat_map(|m| &m.modes).take(3) {
                let root = rijke_network::Root { s: mode.s, steps: 0, residual: 0.0 };
                let _ = built.network.budget(&built.laws, &root, &mut work);
                let _ = built.network.along(&built.laws, &root, 3, &mut work);
                let _ = (built.account(mode), built.along(&root, 3));
            }
        }
    }
}

#[test]
fn exact_files_with_hostile_numbers_do_not_panic() {
    for seed in 0..150 {
        read_and_solve(&mutated(seed));
    }
}

#[test]
#[ignore = "long: 20000 files with hostile numbers, read and solved"]
fn exact_many_files_with_hostile_numbers_do_not_panic() {
    for seed in 400..20_400 {
        read_and_solve(&mutated(seed));
    }
}

fn texts(inputs: [String; 6]) -> OscilosTexts {
    let [geometry, mean_flow, flame, inlet, outlet, scan_range] = inputs;
    OscilosTexts { geometry, mean_flow, flame: Some(flame), inlet, outlet, scan_range }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn exact_no_text_makes_the_reader_panic(text in "\\PC*") {
        let _ = read(&text);
    }

    #[test]
    fn exact_no_broken_file_makes_the_reader_panic(
        file in 0_usize..4,
        cut in 0_usize..1600,
        insert in "[\\[\\]=\"a-z0-9.\\-\n ]{0,12}",
    ) {
        let whole = FILES[file];
        let mut at = cut.min(whole.len());
        while !whole.is_char_boundary(at) {
            at -= 1;
        }
        let _ = read(&format!("{}{insert}{}", &whole[..at], &whole[at..]));
    }

    #[test]
    fn exact_no_folder_of_numbers_makes_the_reader_panic(
        numbers in prop::collection::vec(prop::sample::select(
            &["0", "1", "2", "4", "5", "10", "11", "12", "-1", "-", "0.3", "1e-9", "1e308", "NaN", "inf", "x"][..]
        ), 60),
    ) {
        let row = |from: usize, count: usize| format!("title\n{}\n", numbers[from..from + count].join(" "));
        let geometry = format!(
            "title\n{}\n{}\n{}\n",
            numbers[..4].join(" "), numbers[4..8].join(" "), numbers[8..12].join(" ")
        );
        let inputs = [geometry, row(12, 6), row(18, 3), row(21, 4), row(25, 4), row(29, 6)];
        let _ = read_oscilos(&texts(inputs));
        let good = "t a b c d e f\n101325 293 2 3 1 2\n".to_owned();
        let geometry = "t\n0 0.03 0 0\n0.4 0.01 11 0\n1 0.02 0 0\n".to_owned();
        let inputs = [geometry, good, row(40, 3), row(43, 4), row(47, 4), "t\n0 300 5 -50 50 5\n".to_owned()];
        if let Ok((chain, region)) = read_oscilos(&texts(inputs)) {
            let _ = chain.modes(&Constant, &region, &mut Workspace::default());
        }
    }
}
