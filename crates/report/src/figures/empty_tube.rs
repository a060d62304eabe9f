//! Fig. 3: what one microphone and all microphones know about the ends and the wall of the empty tube.

use crate::{
    comparison::{Comparison, Verdict},
    draw::{Axis, Figure, INK, Key, Mark, Panel, Stroke, fixed},
    page::Item,
    sheet::{Cell, Sheet},
    table::Table,
};
use rijke_studies::{Case, EmptyTube};

/// The three pairs of parameters of Fig. 3, by index: (|R|, angle R), (|R|, eta), (angle R, eta).
pub(super) const PAIRS: [[usize; 2]; 3] = [[0, 1], [0, 2], [1, 2]];
const SIZE: [f64; 2] = [400.0, 320.0];
const CONTOUR: Stroke = Stroke::solid("#0072b2", 1.4);
const PREDICTED: Stroke = Stroke::dashed("#d55e00", 1.2, "5 3");
const TRUTH: Stroke = Stroke::solid(INK, 1.6);

/// Everything the page shows of this study.
pub(crate) fn item(study: &EmptyTube) -> Item {
    Item {
        id: "empty-tube",
        title: "Figure 3: ends and wall of the empty tube".to_owned(),
        introduction: format!(
            "Posterior of the reflection coefficient R of the ends and of the wall-loss factor \u{3b7} from operating point \
             {}. With decay rate and frequency alone, |R| and \u{3b7} explain the same decay and cannot be told apart; the \
             mode shape at all microphones separates them.",
            study.point
        ),
        comparisons: comparisons(study),
        figures: vec![figure(study)],
        tables: vec![table(study)],
        sheets: vec![sheet(study)],
        checks: study.checks.clone(),
        provenance: Some(study.provenance.clone()),
    }
}

/// What section 6.1 says of Fig. 3.
fn comparisons(study: &EmptyTube) -> Vec<Comparison> {
    let (Some(one), Some(all)) = (study.cases.first(), study.cases.last()) else { return Vec::new() };
    let sd = |case: &Case, k: usize| case.covariance[k][k].sqrt();
    let rho = one.correlation[0][2];
    let (eta, eta_sd) = (all.mean[2], sd(all, 2));
    let (radius, angle) = (all.mean[0] - study.predicted[0], all.mean[1] - study.predicted[1]);
    let off = (radius / sd(all, 0)).abs().max((angle / sd(all, 1)).abs());
    vec![
        Comparison {
            what: "|*R*| and *\u{3b7}* from one microphone".to_owned(),
            paper: "\u{201c}a long thin diagonal ellipse\u{201d}".to_owned(),
            ours: format!("correlation {}", fixed(rho, 4)),
            verdict: Verdict::of(rho.abs() > 0.95),
            sentence: "Decay rate and frequency alone do not separate the ends from the wall.".to_owned(),
        },
        Comparison {
            what: format!("*\u{3b7}* from {} microphones", all.microphones.len()),
            paper: "\u{201c}remarkably close to 1.0\u{201d}".to_owned(),
            ours: format!("{} \u{b1} {}", fixed(eta, decimals(eta_sd)), fixed(eta_sd, decimals(eta_sd))),
            verdict: Verdict::of((eta - 1.0).abs() < 0.05),
            sentence: "The paper gives no number; within 0.05 of 1 counts as close, because it calls 1.12 a discrepancy."
                .to_owned(),
        },
        Comparison {
            what: "*R* beside Levine and Schwinger's".to_owned(),
            paper: "\u{201c}deviates slightly\u{201d}".to_owned(),
            ours: format!(
                "|*R*| by {}, \u{2220}*R* by {} rad",
                fixed(radius, decimals(sd(all, 0))),
                fixed(angle, decimals(sd(all, 1)))
            ),
            verdict: Verdict::of(off > 2.0 && radius.abs() < 0.01 && angle.abs() < 0.03),
            sentence: format!(
                "The larger of the two is {} standard deviations: small and seen, for the tube's wall is not infinitely thin.",
                fixed(off, 1)
            ),
        },
    ]
}

/// Rows: pairs of parameters. Columns: one microphone, all microphones on the same axes, all microphones enlarged.
fn figure(study: &EmptyTube) -> Figure {
    let mut panels = Vec::new();
    for (pair, letter) in PAIRS.iter().zip(["a", "b", "c"]) {
        let wide = axes(study, *pair, &study.cases);
        for case in &study.cases {
            let count = case.microphones.len();
            let tag = format!(
                "({letter}.{}) {count} microphone{}",
                roman(count),
                if count == 1 { "" } else { "s" }
            );
            panels.push(panel(study, *pair, &tag, wide.clone(), case));
        }
        if let Some(case) = study.cases.last() {
            let tag = format!("({letter}.{}) enlarged", roman(case.microphones.len()));
            let near = axes(study, *pair, std::slice::from_ref(case));
            panels.push(panel(study, *pair, &tag, near, case));
        }
    }
    let mut legend = vec![
        Key { mark: Mark::Line(CONTOUR), label: "1, 2 and 3 standard deviations".to_owned() },
        Key {
            mark: Mark::Line(PREDICTED),
            label: "predicted: *R* Levine\u{2013}Schwinger, *\u{3b7}* = 1 Rayleigh".to_owned(),
        },
    ];
    if study.truth.is_some() {
        legend.push(Key { mark: Mark::Cross(TRUTH), label: "truth of the virtual laboratory".to_owned() });
    }
    Figure {
        id: "figure-3",
        title: "Posterior of |R|, angle R and wall-loss factor of the empty tube".to_owned(),
        caption: "Posterior probability of the parameters of the empty tube: contours of 1, 2 and 3 standard deviations \
                  about the most probable values. Column (i): decay rate and frequency at the reference microphone only. \
                  Column (viii): decay rate, frequency and relative pressures of all microphones on the same axes, then enlarged."
            .to_owned(),
        columns: study.cases.len() + 1,
        panels,
        legend,
        data: Some(study.provenance.data),
    }
}

/// Axes that hold three standard deviations of the given cases, the prediction and the truth.
fn axes(study: &EmptyTube, pair: [usize; 2], cases: &[Case]) -> [Axis; 2] {
    pair.map(|k| {
        let spans = cases.iter().flat_map(|case| {
            let half = 3.0 * case.covariance[k][k].sqrt();
            [case.mean[k] - half, case.mean[k] + half]
        });
        let marks = [study.predicted[k]].into_iter().chain(study.truth.as_ref().map(|t| t[k]));
        Axis::covering(&label(study, k), spans.chain(marks)).with_most_ticks(6)
    })
}

fn panel(study: &EmptyTube, [i, j]: [usize; 2], tag: &str, [x, y]: [Axis; 2], case: &Case) -> Panel {
    let mut panel = Panel::new(tag, SIZE, x, y);
    panel.vertical(study.predicted[i], &PREDICTED);
    panel.horizontal(study.predicted[j], &PREDICTED);
    for sds in [3.0, 2.0, 1.0] {
        panel.contour(&ellipse(case, [i, j], sds), &CONTOUR, CONTOUR.colour, 0.12);
    }
    let remark = format!("{} microphones, most probable", case.microphones.len());
    panel.dot([case.mean[i], case.mean[j]], 2.2, CONTOUR.colour, &remark);
    if let Some(truth) = &study.truth {
        panel.cross([truth[i], truth[j]], 5.0, &TRUTH);
    }
    panel
}

/// The contour at Mahalanobis distance `sds` of the marginal distribution of two parameters: mean + sds L (cos, sin)
/// with L the Cholesky factor of their covariance.
pub(super) fn ellipse(case: &Case, [i, j]: [usize; 2], sds: f64) -> Vec<[f64; 2]> {
    let covariance = &case.covariance;
    let l11 = covariance[i][i].sqrt();
    let l21 = covariance[j][i] / l11;
    let l22 = (covariance[j][j] - l21 * l21).max(0.0).sqrt();
    let point = |n: u32| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(n) / 120.0).sin_cos();
        [case.mean[i] + sds * l11 * cos, case.mean[j] + sds * (l21 * cos + l22 * sin)]
    };
    (0..120).map(point).collect()
}

fn table(study: &EmptyTube) -> Table {
    let mut head = vec!["Microphones".to_owned()];
    for k in 0..study.parameters.len() {
        head.extend([label(study, k), "sd".to_owned()]);
    }
    head.push("corr(|*R*|, *\u{3b7}*)".to_owned());
    let mut rows: Vec<Vec<String>> = Vec::new();
    for case in &study.cases {
        let mut row = vec![case.microphones.len().to_string()];
        for k in 0..case.mean.len() {
            let sd = case.covariance[k][k].sqrt();
            row.extend([fixed(case.mean[k], decimals(sd)), fixed(sd, decimals(sd))]);
        }
        row.push(fixed(case.correlation[0][2], 4));
        rows.push(row);
    }
    let values = |name: &str, values: &[f64]| {
        let cells = values.iter().flat_map(|&v| [fixed(v, 4), String::new()]);
        [name.to_owned()].into_iter().chain(cells).chain([String::new()]).collect::<Vec<_>>()
    };
    rows.push(values("predicted", &study.predicted));
    if let Some(truth) = &study.truth {
        rows.push(values("truth of the laboratory", truth));
    }
    Table { id: "figure-3", caption: "The same in numbers.".to_owned(), head, rows, ..Table::default() }
}

/// Mean and covariance of every case, one row per pair of parameters.
fn sheet(study: &EmptyTube) -> Sheet {
    let head =
        ["microphones", "parameter", "other_parameter", "mean", "other_mean", "covariance", "correlation"];
    let mut rows = Vec::new();
    for case in &study.cases {
        for (i, first) in study.parameters.iter().enumerate() {
            for (j, second) in study.parameters.iter().enumerate() {
                rows.push(vec![
                    Cell::from(case.microphones.len() as f64),
                    Cell::from(&*first.name),
                    Cell::from(&*second.name),
                    Cell::from(case.mean[i]),
                    Cell::from(case.mean[j]),
                    Cell::from(case.covariance[i][j]),
                    Cell::from(case.correlation[i][j]),
                ]);
            }
        }
    }
    Sheet { id: "figure-3", head: head.map(String::from).to_vec(), rows }
}

/// Decimals that show two digits of a standard deviation.
fn decimals(sd: f64) -> usize {
    if sd > 0.0 { (1.0 - sd.log10().floor()).clamp(0.0, 9.0) as usize } else { 4 }
}

/// Symbol and unit of a parameter.
fn label(study: &EmptyTube, k: usize) -> String {
    let parameter = &study.parameters[k];
    match parameter.unit.as_str() {
        "1" | "" => parameter.symbol.clone(),
        unit => format!("{} / {unit}", parameter.symbol),
    }
}

/// Roman numeral, as the paper numbers its frames by the number of microphones.
pub(super) fn roman(mut n: usize) -> String {
    let mut out = String::new();
    for (value, letters) in [(10, "x"), (9, "ix"), (5, "v"), (4, "iv"), (1, "i")] {
        while n >= value {
            out += letters;
            n -= value;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn exact_contour_lies_at_its_mahalanobis_distance() {
        let covariance = vec![vec![4.0, -1.5], vec![-1.5, 1.0]];
        let case = Case { microphones: vec![0], mean: vec![1.0, 2.0], covariance, correlation: vec![] };
        // Inverse of the covariance: determinant 1.75.
        for [x, y] in ellipse(&case, [0, 1], 3.0) {
            let (u, v) = (x - 1.0, y - 2.0);
            assert_relative_eq!((u * u + 3.0 * u * v + 4.0 * v * v) / 1.75, 9.0, max_relative = 1e-12);
        }
    }

    #[test]
    fn exact_numerals_and_digits() {
        assert_eq!([1, 4, 8, 9, 12].map(roman), ["i", "iv", "viii", "ix", "xii"]);
        assert_eq!([0.012, 0.99, 3.0, 120.0].map(decimals), [3, 2, 1, 0]);
    }
}
