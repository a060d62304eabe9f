//! Tables 2, 3 and 4: competing models, ranked by evidence, beside the published ranking.

use crate::{
    comparison::{Comparison, Verdict},
    draw::fixed,
    sheet::{Cell, Sheet},
    table::Table,
};
use rijke_studies::{Check, ParameterValue, ProngModel};

/// A lead in evidence below which data do not decide, nats: odds of 20 to 1, "strong" in Kass and Raftery (1995).
const DECISIVE: f64 = 3.0;

/// A ranking, in the words of the page.
pub(crate) struct Ranking<'a> {
    /// The models in the order of the table, those beyond the paper last.
    pub(crate) models: &'a [ProngModel],
    /// Identifier of the model of the paper's table with the most evidence.
    pub(crate) winner: &'a str,
    /// That of the paper.
    pub(crate) published_winner: &'a str,
    /// Kendall's tau between the two orders.
    pub(crate) kendall_tau: f64,
    /// What was tried; explains a winner that is not the paper's.
    pub(crate) checks: &'a [Check],
    /// Number of operating points, by which the evidence of a table is divided.
    pub(crate) points: usize,
    /// `Table 2`.
    pub(crate) table: &'static str,
    /// Names of the files of evidence and of parameters.
    pub(crate) files: [&'static str; 2],
}

impl Ranking<'_> {
    /// Model chosen and order of the models, beside the paper's.
    pub(crate) fn comparisons(&self) -> Vec<Comparison> {
        let of = |id: &str, evidence: fn(&ProngModel) -> Option<f64>| {
            let value = self.models.iter().find(|m| m.id == id).and_then(evidence);
            value.map_or_else(|| "none".to_owned(), signed)
        };
        let (verdict, sentence) = self.lead();
        let tau = fixed(self.kendall_tau, 2);
        vec![
            Comparison {
                what: "model with the most evidence".to_owned(),
                paper: self.name(self.published_winner),
                ours: self.name(self.winner),
                verdict,
                sentence,
            },
            Comparison {
                what: "order of the models, most evidence first".to_owned(),
                paper: self.order(|m| m.published.map(|e| e.ln_marginal)),
                ours: self.order(|m| m.published.and(m.evidence).map(|e| e.ln_marginal)),
                verdict: Verdict::of(self.kendall_tau > 1.0 - 1e-9),
                sentence: format!(
                    "Kendall's *\u{3c4}* between the two orders is {tau} (1: the same, 0: no relation)."
                ),
            },
            Comparison {
                what: "ln ML of that model per operating point".to_owned(),
                paper: of(self.published_winner, |m| m.published.map(|e| e.ln_marginal)),
                ours: of(self.winner, |m| m.evidence.map(|e| e.ln_marginal)),
                verdict: Verdict::CannotCompare,
                sentence: "A likelihood belongs to its own data, their noise and their number.".to_owned(),
            },
        ]
    }

    /// How the winner compares with the paper's, and by how much it leads.
    fn lead(&self) -> (Verdict, String) {
        let evidence = |id: &str| self.models.iter().find(|m| m.id == id)?.evidence.map(|e| e.ln_marginal);
        let nats = |id: &str| Some(self.points as f64 * (evidence(self.winner)? - evidence(id)?));
        let others = self.models.iter().filter(|m| m.id != self.winner && m.published.is_some());
        let second = others.filter_map(|m| Some((nats(&m.id)?, m))).min_by(|a, b| a.0.total_cmp(&b.0));
        if self.winner == self.published_winner {
            let lead = second.map_or_else(String::new, |(lead, m)| {
                let weak = if lead < DECISIVE { ", too little to decide between the two" } else { "" };
                format!(" It leads {} by {} nats in all{weak}.", self.name(&m.id), fixed(lead, 1))
            });
            return (Verdict::Agrees, format!("The two sets of data select the same model.{lead}"));
        }
        let Some(lead) = nats(self.published_winner) else {
            return (Verdict::Differs, "The paper's model could not be trained on these data.".to_owned());
        };
        let ahead = format!("It leads the paper's by {} nats in all", fixed(lead, 1));
        if lead < DECISIVE {
            return (Verdict::Undecided, format!("{ahead}, so these data do not decide between the two."));
        }
        // The check that fails because of the winner says which physics of these data makes it so.
        let why = self.checks.iter().filter(|c| !c.holds).find_map(|c| c.explanation.as_deref());
        (Verdict::Differs, format!("{ahead}. {}", why.unwrap_or("")))
    }

    /// Numbers of the models by falling evidence.
    fn order(&self, evidence: impl Fn(&ProngModel) -> Option<f64>) -> String {
        let numbered = self.models.iter().enumerate();
        let mut all: Vec<(f64, String)> =
            numbered.filter_map(|(i, m)| Some((evidence(m)?, number(i, m)))).collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        all.into_iter().map(|(_, number)| number).collect::<Vec<_>>().join(" ")
    }

    /// `model 6 (real drag and blockage)`.
    pub(crate) fn name(&self, id: &str) -> String {
        let found = self.models.iter().enumerate().find(|(_, m)| m.id == id);
        found.map_or_else(|| id.to_owned(), |(i, m)| format!("model {} ({})", number(i, m), m.label))
    }

    /// The ranking beside the published one; candidates beyond the paper stand under a line.
    pub(crate) fn table(&self) -> Table {
        let head = [
            "Model",
            "What it contains",
            "Parameters",
            "ln BFL",
            "ln OF",
            "ln ML",
            "paper: ln BFL",
            "ln OF",
            "ln ML",
        ];
        let row = |(i, model): (usize, &ProngModel)| {
            let mut row = vec![number(i, model), model.label.clone(), model.parameters.len().to_string()];
            for evidence in [model.evidence, model.published] {
                row.extend(match evidence {
                    Some(e) => [e.ln_best_fit, e.ln_occam, e.ln_marginal].map(signed),
                    None => ["\u{2013}"; 3].map(String::from),
                });
            }
            row
        };
        Table {
            id: self.files[0],
            caption: format!(
                "Best-fit likelihood (BFL), Occam factor (OF) and marginal likelihood (ML), natural logarithms per operating \
                 point, ours and as published in {}. The row of the highest marginal likelihood among the paper's models is \
                 marked; candidates beyond the paper stand under the line. The two sets of data differ, so only the order and \
                 the differences can agree.",
                self.table
            ),
            head: head.map(String::from).to_vec(),
            rows: self.models.iter().enumerate().map(row).collect(),
            marked: self.models.iter().position(|m| m.id == self.winner),
            line_above: self.models.iter().position(|m| m.published.is_none()),
            dense: false,
        }
    }

    /// The trained parameters and the noise each model needs.
    pub(crate) fn parameters(&self) -> Table {
        let head = [
            "Model",
            "Parameters, most probable \u{b1} sd",
            "noise of *s*_{r} / s^{-1}",
            "noise of *s*_{i} / rad s^{-1}",
            "noise of *P*",
        ];
        let row = |(i, model): (usize, &ProngModel)| {
            let parameters = model.parameters.iter().map(valued).collect::<Vec<_>>().join("; ");
            let noise =
                [model.growth_rate_noise_sd, model.angular_frequency_noise_sd, model.pressure_noise_sd];
            [number(i, model), parameters].into_iter().chain(noise.map(|sd| fixed(sd, 4))).collect()
        };
        Table {
            id: self.files[1],
            caption: "Trained parameters, with standard deviations by Laplace's method, and the standard deviation of the \
                      measurement noise that maximises each model's posterior."
                .to_owned(),
            head: head.map(String::from).to_vec(),
            rows: self.models.iter().enumerate().map(row).collect(),
            line_above: self.models.iter().position(|m| m.published.is_none()),
            ..Table::default()
        }
    }

    /// The ranking as numbers: a row per model.
    pub(crate) fn evidence(&self) -> Sheet {
        let head = [
            "model",
            "contains",
            "parameters",
            "ln_best_fit",
            "ln_occam",
            "ln_marginal",
            "published_ln_best_fit",
            "published_ln_occam",
            "published_ln_marginal",
            "growth_rate_noise_sd_per_s",
            "angular_frequency_noise_sd_rad_per_s",
            "pressure_noise_sd",
        ];
        let row = |model: &ProngModel| {
            let mut row = vec![
                Cell::from(&*model.id),
                Cell::from(&*model.label),
                Cell::from(model.parameters.len() as f64),
            ];
            for evidence in [model.evidence, model.published] {
                row.extend(match evidence {
                    Some(e) => [e.ln_best_fit, e.ln_occam, e.ln_marginal].map(Cell::from),
                    None => [Cell::Empty, Cell::Empty, Cell::Empty],
                });
            }
            let noise =
                [model.growth_rate_noise_sd, model.angular_frequency_noise_sd, model.pressure_noise_sd];
            row.extend(noise.map(Cell::from));
            row
        };
        let rows = self.models.iter().map(row).collect();
        Sheet { id: self.files[0], head: head.map(String::from).to_vec(), rows }
    }

    /// The trained parameters as numbers: a row per model and parameter.
    pub(crate) fn values(&self) -> Sheet {
        let head = ["model", "parameter", "unit", "most_probable", "sd"].map(String::from).to_vec();
        let rows = self.models.iter().flat_map(|model| {
            model.parameters.iter().map(|p| {
                vec![
                    Cell::from(&*model.id),
                    Cell::from(&*p.name),
                    Cell::from(&*p.unit),
                    Cell::from(p.value),
                    Cell::from(p.sd),
                ]
            })
        });
        Sheet { id: self.files[1], head, rows: rows.collect() }
    }
}

/// `eta = 1.02 +- 0.01`, with two digits of the standard deviation; a parameter that was held has none.
pub(crate) fn valued(p: &ParameterValue) -> String {
    let unit = if p.unit == "1" { String::new() } else { format!(" {}", p.unit) };
    let number = |value: f64| match p.sd > 0.0 {
        true => rounded(value, p.sd),
        false => rounded(value, 0.01 * value.abs()),
    };
    if p.sd > 0.0 {
        format!("{} = {} \u{b1} {}{unit}", p.symbol, number(p.value), number(p.sd))
    } else {
        format!("{} = {}{unit}", p.symbol, number(p.value))
    }
}

/// A value with as many decimals as show two digits of its standard deviation; tiny ones as powers of ten.
pub(crate) fn rounded(value: f64, sd: f64) -> String {
    if !(sd > 0.0 && sd.is_finite()) {
        return fixed(value, 4);
    }
    let decimals = (1.0 - sd.log10().floor()).max(0.0) as usize;
    if decimals <= 5 {
        return fixed(value, decimals);
    }
    let power = value.abs().max(sd).log10().floor() as i32;
    let digits = (decimals as i32 + power).max(0) as usize;
    format!("{}\u{b7}10^{{{power}}}", fixed(value / 10f64.powi(power), digits))
}

/// A number with its sign and four decimals.
fn signed(value: f64) -> String {
    if value >= 0.0 { format!("+{}", fixed(value, 4)) } else { fixed(value, 4) }
}

/// Row of the paper's table, or the place in ours for a candidate that the paper does not have.
pub(crate) fn number(index: usize, model: &ProngModel) -> String {
    model.number.map_or_else(|| format!("+{}", index + 1), |n| n.to_string())
}

/// For legends.
pub(crate) fn title(index: usize, model: &ProngModel) -> String {
    format!("{}: {}", number(index, model), model.label)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_values_show_two_digits_of_their_sd() {
        assert_eq!(rounded(1.02345, 0.0123), "1.023");
        assert_eq!(rounded(3.141_59e-4, 2.5e-6), "3.142\u{b7}10^{-4}");
        assert_eq!(rounded(123.4, 30.0), "123");
    }
}
