//! Observations that were prepared by hand: the examples of `docs/records-format.md` are read as they stand
//! there.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may fail by panicking")]

use rijke_numerics::C64;
use rijke_rig::{Observations, Rejection};
use std::path::PathBuf;

/// The text of the fenced block of the page that is called `name`.
fn example(name: &str) -> String {
    let page = include_str!("../../../../docs/records-format.md");
    let (_, rest) = page.split_once(&format!(" {name}\n")).unwrap();
    rest.split_once("```").unwrap().0.to_owned()
}

/// A folder with the examples and a rig of one microphone.
fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("rijke-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    for file in ["observations.toml", "points.csv", "pings.csv"] {
        std::fs::write(folder.join(file), example(file)).unwrap();
    }
    let rig = include_str!("../../data/rig.toml");
    let (head, rest) = rig.split_once("positions = [").unwrap();
    let rig = format!("{head}positions = [0.75]{}", rest.split_once(']').unwrap().1).replacen(
        "reference = 5",
        "reference = 0",
        1,
    );
    std::fs::write(folder.join("rig.toml"), rig).unwrap();
    folder
}

#[test]
fn exact_the_examples_of_the_page_are_observations() {
    let folder = folder("by-hand");
    let read = Observations::read(&folder).unwrap();
    assert_eq!((read.points.len(), read.rig.microphones.positions.len()), (3, 1));
    let hot = &read.points[2];
    let ping = hot.ping.as_ref().unwrap();
    assert_eq!(
        (hot.point.factor("Q_h"), hot.point.factor("X_h"), ping.s),
        (Some(60.0), Some(0.2), C64::new(-3.1, 1092.3))
    );
    assert_eq!(
        (ping.covariance[(0, 0)], ping.covariance[(0, 1)], ping.covariance[(1, 1)]),
        (0.08 * 0.08, 0.0, 0.25)
    );
    assert_eq!((hot.point.repeats, hot.ping_count, &*hot.ambient.id), (1, 1, "day"));
    // Written and read again they are the same, now with covariances.
    read.write(&folder).unwrap();
    assert_eq!(Observations::read(&folder).unwrap(), read);
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn exact_messages_of_tables_prepared_by_hand() {
    let folder = folder("by-hand-wrong");
    let refused = |file: &str, from: &str, to: &str, says: &str| {
        let text = example(file);
        assert!(text.contains(from));
        std::fs::write(folder.join(file), text.replacen(from, to, 1)).unwrap();
        let said = Observations::read(&folder).unwrap_err().to_string();
        assert!(said.contains(says) && said.contains(file), "{said}");
        std::fs::write(folder.join(file), text).unwrap();
    };
    refused(
        "pings.csv",
        "-6.21,1041.7,0.05",
        "-6.21,1041.7,0",
        "line 2, column `growth_rate_sd [1/s]`: `0` is not a positive",
    );
    let lacking = "line 1: there is no column `T_amb [K]`; the file has `point`";
    refused("points.csv", "T_amb [K]", "T_amb [C]", lacking);
    // A column that is not known is a factor with its unit, or refused.
    let unknown = "is no column of this table; a factor has its unit in the heading";
    refused("points.csv", "Q_h [W]", "power", &format!("line 1, column `power`: {unknown}"));
    refused("points.csv", "Q_h [W]", "Q_h [watt]", "column `Q_h [watt]`: `watt`");
    refused("points.csv", "Q_h [W]", "X_h [m]", "`X_h [m]` appears twice");
    refused("points.csv", "Q_h [W]", "X_h [mm]", "`X_h` appears twice");
    refused("points.csv", ",60,", ",hot,", "line 4, column `Q_h [W]`: `hot` is not a finite number");
    refused("points.csv", "293.4", "20 C", "line 2, column `T_amb [K]`: `20 C`");
    refused(
        "pings.csv",
        "cold-20",
        "cold-2",
        "line 3, column `point`: `cold-2` is not known; known: cold-20, empty, hot-20",
    );
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn exact_the_reason_of_most_rejections_is_counted() {
    let folder = folder("reasons");
    let mut read = Observations::read(&folder).unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    let of = |reasons: &[&str]| {
        let one = |(k, r): (usize, &&str)| Rejection { record: format!("r{k}"), reason: (*r).to_owned() };
        reasons.iter().enumerate().map(one).collect::<Vec<_>>()
    };
    let same = ["channel 3 is dead: 0.1", "clipped", "channel 3 is dead: 0.2", "too short: 3"];
    read.rejections = of(&same);
    let (count, first) = read.main_reason().unwrap();
    assert_eq!((count, &*first.record, &*first.reason), (2, "r0", "channel 3 is dead: 0.1"));
    for few in [&same[..2], &[], &["a: 1", "b: 1", "c: 1"]] {
        read.rejections = of(few);
        assert_eq!(read.main_reason(), None, "{few:?}");
    }
}
