//! Measured tables in candidates.

use super::{CLOSED, LOSSY, conditions, network, study, table};
use crate::common::folder::Folder;
use crate::common::tube::{TUBE, speed};
use rijke_engine::run::{Run, Trusted, forecast};
use rijke_engine::{Assembly, PointModel};
use rijke_study::{Catalogue, Study};
use std::collections::BTreeMap;
use std::sync::Arc;

fn candidates(study: &Study, name: &str, text: &str) -> Result<Catalogue, String> {
    let path = std::env::temp_dir().join(format!("rijke-elements-{name}-{}.toml", std::process::id()));
    std::fs::write(&path, text).unwrap();
    let read = Catalogue::read(&path, &study.rig);
    std::fs::remove_file(&path).unwrap();
    read.map_err(|error| error.to_string())
}

const OF_A_TABLE: &str = "[[candidate]]\nid = 'flame.table'\nrole = 'flame'\nname = 'table'\ncite = ['own judgement']\n\
                          parameters.n = { prior = { normal = { mean = 1, sd = 1 } } }\ntables.F = { table = TABLE, tolerance = 1e-3MORE }\n\
                          [[candidate.effect]]\nacts_at = 'flame'\neu = '-n*F'\n";

/// The same table in a candidate as in a flame of the file; and of a time scale of its own.
#[test]
fn exact_a_candidate_has_the_table_of_a_flame() {
    let rig = |element: &str| network(&format!("[[element]]\nname = 'flame'\n{element}\n"), [CLOSED, LOSSY]);
    let device = study("device", &rig("type = 'device'\nnumbers = { fast = '0.5' }")).unwrap();
    let s = |study: &Study, candidates: Vec<rijke_study::Candidate>, values: &[f64]| {
        let assembly = Assembly::new(Arc::new(study.rig.clone()), candidates, &BTreeMap::new()).unwrap();
        let conditions = conditions(study);
        let model = PointModel::new(&assembly, &conditions, &[]).unwrap();
        let (_, spectrum) = model.spectrum(values, [None, None]).unwrap();
        spectrum.modes.modes.iter().map(|m| m.s).collect::<Vec<_>>()
    };
    let spaced = table().replace('[', " [");
    let quicker = spaced.split(" [").skip(2).map(|row| {
        let (hertz, rest) = row.split_once(',').unwrap();
        format!("[{},{rest}", 2.0 * hertz.trim().parse::<f64>().unwrap())
    });
    let quicker = format!("[{}", quicker.collect::<String>());
    for (more, rows) in [("", table()), (", of = 's*fast'", quicker.clone()), (", of = 's*half'", quicker)] {
        let text = OF_A_TABLE.replace("TABLE", &table()).replace("MORE", more);
        // A name that stands below the table which uses it.
        let named = "where.half = 'fast'\n[[candidate.effect]]";
        let text = if more.contains("half") { text.replace("[[candidate.effect]]", named) } else { text };
        let catalogue = candidates(&device, "same", &text).unwrap();
        assert!(catalogue.doubts.is_empty(), "{:?}", catalogue.doubts);
        let flame = format!("type = 'flame'\ngain = 0.4\ntolerance = 1e-3\ntable = {rows}");
        let expected = s(&study("flame", &rig(&flame)).unwrap(), Vec::new(), &[]);
        let found = s(&device, catalogue.candidates().to_vec(), &[0.4]);
        assert!(found.len() == expected.len() && found.len() >= 4, "{found:?} {expected:?}");
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).norm() < 1e-7 * expected.norm(), "{more}: {found} {expected}");
        }
    }
    for (from, to, said) in [
        ("eu = '-n*F'", "eu = '-n'", "`F` is used nowhere"),
        ("tolerance", "tolerence", "there is no key `tolerence`; did you mean `tolerance`?"),
        ("table = TABLE", "table = 'nowhere.csv'", "nowhere.csv"),
        ("1e-3MORE", "0.9", "at most 0.5"),
        ("tables.F", "tables.n", "a parameter"),
        ("tables.F", "tables.rho", "density"),
        ("MORE", ", of = 'n*T'", "unit"),
    ] {
        let text = OF_A_TABLE.replace(from, to).replace("TABLE", &table()).replace("MORE", "");
        let error = candidates(&device, "bad", &text).map(|_| ()).unwrap_err();
        assert!(error.contains(".toml, line ") && error.contains(said), "{said}: {error}");
    }
}

/// A law that hardly acts, so that modes have a closed form; it asks its table at twice their frequency.
#[test]
fn message_modes_that_ask_a_table_beyond_its_frequencies() {
    let rig = format!(
        "{TUBE}[[element]]\nname = 'flame'\ntype = 'device'\nnumbers = {{ twice = '2' }}\n[[element]]\ntype = 'duct'\nlength = '0.5 m'\n\
         diameter = '50 mm'\n"
    );
    let table = "[[50, 1, 0], [100, 1, 0], [150, 1, 0], [TOP, 1, 0]]";
    let (length, c) = (1.5, speed());
    let row =
        |n: f64| format!("a,{n},{:.9},0.5,{:.9},0.1\n", c * 0.85_f64.ln() / length, n * 0.5 * c / length);
    let head = "point,mode,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n";
    let modes = [head.to_owned(), row(1.0), row(2.0)].concat();
    let plan = "name = 't'\n[[stage]]\nid = 's'\npoints = {}\ncompete = 'flame'\n[stage.noise]\ngrowth_rate = 0.0\nangular_frequency = 0.0\n";
    for (top, asked) in [("500", None), ("300", Some(2.0)), ("200", Some(1.0))] {
        let law = OF_A_TABLE.replace("MORE", ", of = 's*twice'").replace("TABLE", &table.replace("TOP", top));
        let law = law.replace("mean = 1, sd = 1", "mean = 1e-6, sd = 1e-7");
        let folder = Folder::new(
            &format!("beyond-{top}"),
            &[
                ("rig.toml", &rig),
                ("campaign.csv", "point,x [cm],T_amb [degC]\na,100,20\n"),
                ("study.toml", plan),
                ("candidates/flame.toml", &law),
                ("observations/observations.toml", "kind = \"virtual\"\nsource = \"closed form\"\n"),
                ("observations/modes.csv", &modes),
            ],
        );
        let study = Study::open(&folder.0).unwrap();
        let observations = study.observations().unwrap();
        let mut run = Run::new(study.clone(), &observations, Trusted::Laplace).unwrap();
        let remark = run.next_stage().unwrap().unwrap().models.remove(0).remark;
        let said = asked.map(|n: f64| {
            let modes = if n < 2.0 { "2 measured modes lie" } else { "one measured mode lies" };
            let hertz = n * c / length;
            format!(
                "{modes} beyond a table, where its fit extrapolates; at a: the table `F` of `flame` is asked at {hertz:.1} Hz, and was measured from 50 to \
                 {top} Hz"
            )
        });
        let found = remark.iter().flat_map(|r| r.lines()).find(|line| line.contains("beyond a table"));
        assert_eq!(found.map(str::to_owned), said);
        let saved = run.saved("s").unwrap();
        let (found, _) = forecast(&study, &observations, &saved, &[], &[0]).unwrap();
        let beyond: Vec<bool> = found.iter().map(|f| f.beyond[0].is_some()).collect();
        assert_eq!(beyond, [asked == Some(1.0), asked.is_some()]);
    }
}
