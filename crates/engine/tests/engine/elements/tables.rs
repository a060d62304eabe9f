//! Measured tables in candidates.

use super::{CLOSED, LOSSY, conditions, network, study, table};
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
    for (more, rows) in [("", table()), (", of = 's*fast'", quicker)] {
        let text = OF_A_TABLE.replace("TABLE", &table()).replace("MORE", more);
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
        ("tolerance", "tolerence", "unknown field `tolerence`"),
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
