//! Forecasts: members that fail, members in groups, threads.

use super::*;

#[test]
fn exact_failed_members_are_replaced_and_listed() {
    let p = problem(10, 2, 1);
    let model = |member: usize, row: &mut [f64]| {
        if member == 3 && row[0] == p.ensemble.members()[(3, 0)] { Err("left the table") } else { Ok(row[0]) }
    };
    let mut ensemble = p.ensemble.clone();
    let out = ensemble.forecast(7, &mut Streams::new(1).stream("f"), model).unwrap();
    assert_eq!(out.len(), 10);
    assert_eq!(ensemble.failures(), [Failure { member: 3, step: 7, reason: "left the table".into() }]);
    assert_ne!(ensemble.members().row(3), p.ensemble.members().row(3));
    let all = |_: usize, _: &mut [f64]| Err::<(), _>("broken");
    let refused = ensemble.forecast(8, &mut Streams::new(1).stream("f"), all);
    assert!(matches!(refused, Err(EnsembleError::Failed { failed: 10, step: 8, .. })));
}

#[test]
fn exact_members_run_in_groups_change_no_byte() {
    // Every seventh member fails, so groups hold sound and failed members; the last group is short.
    let one = |i: usize, row: &mut [f64]| {
        row.iter_mut().for_each(|v| *v = v.sin());
        if i % 7 == 3 { Err(format!("member {i} fails")) } else { Ok(row.iter().sum::<f64>()) }
    };
    let run = |group: usize| {
        let mut ensemble = problem(41, 3, 2).ensemble;
        // The replacements must pass: they are the only rows that run alone in a group of more than one.
        let tried = std::sync::Mutex::new(std::collections::HashSet::new());
        let model = |first: usize, rows: &mut [f64]| -> Vec<Result<f64, String>> {
            let each = |(k, row): (usize, &mut [f64])| {
                let again = !tried.lock().unwrap().insert(first + k);
                let result = one(first + k, row);
                if again { Ok(row.iter().sum()) } else { result }
            };
            rows.chunks_mut(3).enumerate().map(each).collect()
        };
        let mut stream = Streams::new(4).stream("groups");
        let out = ensemble.forecast_in_groups(2, &mut stream, group, model).unwrap();
        (out, ensemble)
    };
    let alone = run(1);
    assert_eq!(alone.1.failures().len(), 6, "{:?}", alone.1.failures());
    for group in [2, 4, 64] {
        assert_eq!(run(group), alone, "groups of {group}");
    }
    let mut ensemble = problem(41, 3, 2).ensemble;
    let few = |_: usize, _: &mut [f64]| vec![Ok::<_, String>(0.0)];
    let refused = ensemble.forecast_in_groups(0, &mut Streams::new(1).stream("f"), 4, few);
    assert!(matches!(refused, Err(EnsembleError::Shape { expected: 41, got: 11, .. })), "{refused:?}");
}

#[test]
fn exact_thread_count_changes_no_byte() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut ensemble = problem(40, 3, 2).ensemble;
            let mut stream = Streams::new(4).stream("threads");
            let model = |_: usize, row: &mut [f64]| {
                row.iter_mut().for_each(|v| *v = v.sin());
                Ok::<_, std::convert::Infallible>(row.iter().sum::<f64>())
            };
            let out = ensemble.forecast(0, &mut stream, model).unwrap();
            let predicted = Matrix::from_fn(40, 1, |i, _| out[i]);
            let noise = NoiseCovariance::Independent(vec![0.1]);
            let observed = EnsembleData { predicted: &predicted, measured: &[0.2], noise: &noise };
            ensemble.analyse(&observed, Scheme::RotatedSquareRoot, &mut stream).unwrap();
            ensemble
        })
    };
    assert_eq!(run(1), run(2));
}
