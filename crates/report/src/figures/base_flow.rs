//! Fig. 2: velocity at the heater and speed of sound along the tube.

use super::powers::{colours, legend, position_axis, powers};
use crate::{
    base_flow::{BaseFlow, FlowAtPower, FlowRun},
    comparison::{Comparison, Verdict},
    draw::{Axis, Figure, Key, Mark, Panel, Stroke, fixed, scale_colour},
    page::Item,
    sheet::{Cell, Sheet},
    table::Table,
};

const SIZE: [f64; 2] = [560.0, 400.0];
/// Number of the paper's parameters among the unknowns.
const PARAMETERS: usize = 6;

/// Everything the page shows of this study.
pub(crate) fn item(study: &BaseFlow) -> Item {
    Item {
        id: "base-flow",
        title: "Figure 2: velocity at the heater and speed of sound".to_owned(),
        introduction: format!(
            "Base flow at {} positions of the heater, inferred from the arrival times of clicks with the one-dimensional pipe \
             flow model.",
            study.runs.len()
        ),
        comparisons: comparisons(study),
        figures: vec![figure(study)],
        tables: vec![parameters(study)],
        sheets: vec![velocities(study), profiles(study)],
        checks: Vec::new(),
        provenance: None,
    }
}

/// Positions ascending.
fn runs(study: &BaseFlow) -> Vec<&FlowRun> {
    let mut runs: Vec<_> = study.runs.iter().collect();
    runs.sort_by(|a, b| a.heater_m.total_cmp(&b.heater_m));
    runs
}

/// The highest power of all.
fn highest(study: &BaseFlow) -> f64 {
    study.runs.iter().flat_map(|r| &r.powers).map(|p| p.power_w).fold(0.0, f64::max)
}

/// The highest speed of sound along the tube.
fn fastest(at: &FlowAtPower) -> f64 {
    at.profile.iter().map(|p| p.sound_speed).fold(f64::NEG_INFINITY, f64::max)
}

fn comparisons(study: &BaseFlow) -> Vec<Comparison> {
    let (runs, power) = (runs(study), highest(study));
    let at = |run: &&FlowRun| run.powers.iter().find(|p| p.power_w == power).cloned();
    let hot: Vec<(f64, FlowAtPower)> = runs.iter().filter_map(|r| Some((r.heater_m, at(r)?))).collect();
    let (Some(low), Some(high)) = (hot.first(), hot.last()) else { return Vec::new() };
    if hot.len() < 2 {
        return Vec::new();
    }
    let steps = hot.windows(2);
    let falls = steps.clone().filter(|w| w[1].1.heater_velocity < w[0].1.heater_velocity).count();
    let rises = steps.filter(|w| fastest(&w[1].1) > fastest(&w[0].1)).count();
    let of = hot.len() - 1;
    let most = hot.iter().map(|(_, p)| p.heater_velocity).fold(0.0, f64::max);
    vec![
        Comparison {
            what: "velocity at the heater as it is moved up".to_owned(),
            paper: "decreases, though not smoothly".to_owned(),
            ours: format!(
                "{} to {} m/s at {} W; falls in {falls} of {of} steps",
                fixed(low.1.heater_velocity, 3),
                fixed(high.1.heater_velocity, 3),
                fixed(power, 0)
            ),
            verdict: Verdict::of(high.1.heater_velocity < low.1.heater_velocity),
            sentence: "The column of hot air that drives the flow becomes shorter.".to_owned(),
        },
        Comparison {
            what: "highest velocity at the heater".to_owned(),
            paper: "about 0.6 m/s".to_owned(),
            ours: format!("{} m/s", fixed(most, 2)),
            verdict: Verdict::of((0.4..0.9).contains(&most)),
            sentence: "The paper calls its flow about that of an earlier rig, 0.6 m/s; within a factor of 1.5 agrees.".to_owned(),
        },
        Comparison {
            what: "highest speed of sound as the heater is moved up".to_owned(),
            paper: "increases, though not smoothly".to_owned(),
            ours: format!(
                "{} to {} m/s at {} W; rises in {rises} of {of} steps",
                fixed(fastest(&low.1), 1),
                fixed(fastest(&high.1), 1),
                fixed(power, 0)
            ),
            verdict: Verdict::of(fastest(&high.1) > fastest(&low.1)),
            sentence: "Less flow takes up the same power, so the temperature jump grows.".to_owned(),
        },
    ]
}

/// Fig. 2.
pub(crate) fn figure(study: &BaseFlow) -> Figure {
    let powers = powers(study.runs.iter().flat_map(|r| &r.powers).map(|p| p.power_w).filter(|p| *p > 0.0));
    let mut legend = legend(&powers);
    let patch = |label: &str| Key { mark: Mark::Patch("#3c7bb0"), label: label.to_owned() };
    legend.push(patch("\u{b1}2 standard deviations"));
    let ends = runs(study);
    for (run, colour) in [(ends.first(), scale_colour(0, 2)), (ends.last(), scale_colour(1, 2))]
        .into_iter()
        .filter(|_| ends.len() > 1)
    {
        let label = run.map_or_else(String::new, |r| format!("(b) *X*_{{h}} = {} m", fixed(r.heater_m, 2)));
        legend.push(Key { mark: Mark::Line(Stroke::solid(colour, 1.6)), label });
    }
    Figure {
        id: "figure-2",
        title: "Velocity at the heater and speed of sound along the tube".to_owned(),
        caption: format!(
            "(a) Velocity at the heater against its position, one colour per power; patches: \u{b1}2 standard deviations. \
             (b) Local speed of sound along the tube at {} W, one line per position of the heater, from blue (lowest) to red \
             (highest), with its standard deviations where the lines of the lowest and the highest position run.",
            fixed(highest(study), 0)
        ),
        columns: 2,
        panels: vec![velocity_panel(study, &powers), profile_panel(study)],
        legend,
        data: Some(study.kind),
    }
}

fn velocity_panel(study: &BaseFlow, powers: &[f64]) -> Panel {
    let line = |power: f64| {
        let at = |r: &&FlowRun| {
            let p = r.powers.iter().find(|p| p.power_w == power)?;
            Some([r.heater_m, p.heater_velocity, p.heater_velocity_sd])
        };
        runs(study).iter().filter_map(at).collect::<Vec<_>>()
    };
    let held = powers.iter().flat_map(|p| line(*p)).flat_map(|[_, u, sd]| [u - 2.0 * sd, u + 2.0 * sd]);
    let y =
        Axis::covering("Velocity at the heater *U*_{h} / m s^{-1}", held.chain([0.0]).collect::<Vec<_>>());
    let mut panel = Panel::new("(a)", SIZE, position_axis(), y);
    for (power, colour) in colours(powers) {
        let band: Vec<_> = line(power).iter().map(|[x, u, sd]| [*x, u - 2.0 * sd, u + 2.0 * sd]).collect();
        panel.band(&band, colour, 0.12);
    }
    for (power, colour) in colours(powers) {
        let line = line(power);
        panel.curve(&line.iter().map(|[x, u, _]| [*x, *u]).collect::<Vec<_>>(), &Stroke::solid(colour, 1.6));
        for [x, u, sd] in line {
            let remark = format!(
                "{} W, {} m: {} \u{b1} {} m/s",
                fixed(power, 0),
                fixed(x, 2),
                fixed(u, 3),
                fixed(sd, 3)
            );
            panel.dot([x, u], 2.2, colour, &remark);
        }
    }
    panel
}

fn profile_panel(study: &BaseFlow) -> Panel {
    let (runs, power) = (runs(study), highest(study));
    let hot: Vec<&FlowAtPower> =
        runs.iter().filter_map(|r| r.powers.iter().find(|p| p.power_w == power)).collect();
    let all = hot.iter().flat_map(|p| &p.profile);
    let y = Axis::covering(
        "Speed of sound *c* / m s^{-1}",
        all.clone().map(|p| p.sound_speed).collect::<Vec<_>>(),
    );
    let length = all.map(|p| p.x).fold(0.0, f64::max);
    let mut panel = Panel::new("(b)", SIZE, Axis::new("*x* / m", 0.0, length.max(1e-9)), y);
    for (i, at) in hot.iter().enumerate() {
        let colour = scale_colour(i, hot.len());
        if i == 0 || i + 1 == hot.len() {
            let band = |p: &crate::base_flow::FlowAt| {
                let half = 2.0 * p.sound_speed_sd;
                [p.x, p.sound_speed - half, p.sound_speed + half]
            };
            panel.band(&at.profile.iter().map(band).collect::<Vec<_>>(), colour, 0.15);
        }
        let line: Vec<_> = at.profile.iter().map(|p| [p.x, p.sound_speed]).collect();
        panel.curve(&line, &Stroke::solid(colour, 1.4));
    }
    panel
}

/// The paper's six parameters at each position, with two standard deviations.
fn parameters(study: &BaseFlow) -> Table {
    let runs = runs(study);
    let first = runs.first().map_or(&[][..], |r| &r.unknowns[..r.unknowns.len().min(PARAMETERS)]);
    let titles = first.iter().map(|u| match u.unit.as_str() {
        "1" | "" => u.name.replace('_', " "),
        unit => format!("{} / {unit}", u.name.replace('_', " ")),
    });
    let row = |run: &&FlowRun| {
        let cell = |u: &crate::base_flow::FlowUnknown| {
            let mark = if u.shrinkage > 0.7 { "\u{2020}" } else { "" };
            format!("{} [{}, {}]{mark}", fixed(u.value, 2), fixed(u.low, 2), fixed(u.high, 2))
        };
        let values = run.unknowns.iter().take(PARAMETERS).map(cell);
        [fixed(run.heater_m, 2)].into_iter().chain(values).collect()
    };
    Table {
        id: "figure-2",
        caption: "The six parameters of the flow model at each position of the heater, most probable value and two standard \
                  deviations. \u{2020}: not identified by these data, the posterior is nearly the prior."
            .to_owned(),
        head: ["*X*_{h} / m".to_owned()].into_iter().chain(titles).collect(),
        rows: runs.iter().map(row).collect(),
        dense: true,
        ..Table::default()
    }
}

fn velocities(study: &BaseFlow) -> Sheet {
    let head = ["heater_m", "power_w", "heater_velocity_m_per_s", "heater_velocity_sd_m_per_s"];
    let rows = runs(study).into_iter().flat_map(|r| {
        r.powers.iter().map(|p| {
            [r.heater_m, p.power_w, p.heater_velocity, p.heater_velocity_sd]
                .map(Cell::from)
                .into_iter()
                .collect()
        })
    });
    Sheet { id: "figure-2a", head: head.map(String::from).to_vec(), rows: rows.collect() }
}

fn profiles(study: &BaseFlow) -> Sheet {
    let head =
        ["heater_m", "power_w", "x_m", "temperature_k", "sound_speed_m_per_s", "sound_speed_sd_m_per_s"];
    let rows = runs(study).into_iter().flat_map(|r| {
        r.powers.iter().flat_map(move |p| {
            p.profile.iter().map(move |at| {
                [r.heater_m, p.power_w, at.x, at.temperature, at.sound_speed, at.sound_speed_sd]
                    .map(Cell::from)
                    .into_iter()
                    .collect()
            })
        })
    });
    Sheet { id: "figure-2b", head: head.map(String::from).to_vec(), rows: rows.collect() }
}
