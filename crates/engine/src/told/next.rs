//! What is said of what to measure next.

use crate::run::{Aim, MicrophoneChoice, MicrophoneTable, Next, Step, Suggestion};
use rijke_numerics::Tell;
use rijke_numerics::words::fixed;

/// Rows that are said; the records have all.
const SHOWN: usize = 12;

/// Information on the choice of models below which a plan tells nothing of it, nats.
const NO_DIFFERENCE: f64 = 1e-3;

impl Next {
    /// Says what every point would bring, and the plan; `about` is the condition that was asked about, as it
    /// was written.
    pub fn tell(&self, about: Option<&str>, tell: &dyn Tell) {
        let names = |k: usize| {
            let of = |m: &std::collections::BTreeMap<String, String>| m.values().cloned().collect::<Vec<_>>();
            let (all, other) = (of(&self.models[k]), of(&self.models[1 - k.min(1)]));
            // The same candidates at another maximum of their posterior.
            let alike = all == other;
            let own: Vec<String> = all.into_iter().filter(|id| alike || !other.contains(id)).collect();
            format!("{}{}", own.join(" + "), if alike && k > 0 { " at another maximum" } else { "" })
        };
        if self.models.len() > 1 {
            tell.say(format!("{}: {} against {}", self.stage, names(0), names(1)));
        }
        if let Some(entropy) = self.entropy {
            tell.say(format!(
            "{} models are undecided (entropy {entropy:.3} nats). Column `which model` is the part of it that a point is expected to resolve",
            self.models.len()
        ));
        }
        let hours = |h: Option<f64>| h.map_or(String::new(), |h| format!("{h:.2}"));
        let number = |v: Option<f64>| v.map_or(String::new(), |v| fixed(v, 3));
        let row = |s: &Suggestion| {
            let [first, second] = [0, 1].map(|k| number(s.models.map(|m| m[k])));
            let (parameters, nats) = (number(Some(s.parameters)), number(Some(s.nats)));
            let point = format!("{}{}", s.point, if s.repeat { " (repeat)" } else { "" });
            [parameters, first, second, number(s.which), number(s.quantity), nats, hours(s.hours), point]
        };
        let head = [
            "parameters",
            "if first right",
            "if second right",
            "which model",
            "asked",
            "aim",
            "hours",
            "point",
        ];
        let rows: Vec<_> = self.points.iter().take(SHOWN).map(row).collect();
        let filled: Vec<usize> = (0..head.len()).filter(|k| rows.iter().any(|r| !r[*k].is_empty())).collect();
        let rows =
            rows.into_iter().map(|row| filled.iter().map(move |k| row[*k].clone()).collect::<Vec<_>>());
        let head = filled.iter().map(|k| head[*k].to_owned()).collect();
        tell.table(head, rows.collect());
        if self.points.len() > SHOWN {
            tell.say(format!("  and {} more", self.points.len() - SHOWN));
        }
        for (point, why) in self.left_out.iter().take(SHOWN) {
            tell.note(format!("{point} is left out: {why}"));
        }
        let [plan, greedy] = self.total.map(|nats| fixed(nats, 3));
        tell.say(format!("Plan: {plan} nats together ({greedy} before points were exchanged)"));
        if self.aim == Aim::Models && self.total[0] < NO_DIFFERENCE {
            tell.say(
                "No measurement at these points distinguishes the models: they predict the same".to_owned(),
            );
        }
        let row = |step: &Step| [fixed(step.adds, 3), hours(step.hours), step.point.clone()];
        let kept = |k: &usize| *k != 1 || self.plan.iter().any(|step| step.hours.is_some());
        let filled: Vec<usize> = (0..3).filter(kept).collect();
        let rows = self
            .plan
            .iter()
            .map(row)
            .map(|row| filled.iter().map(move |k| row[*k].clone()).collect::<Vec<_>>());
        let head = filled.iter().map(|k| ["adds, nats", "hours", "point"][*k].to_owned()).collect();
        tell.table(head, rows.collect());
        if let Some(of) = self.factor.filter(|_| self.aim == Aim::Models) {
            let [first, second] = of.map(|[mean, sd]| format!("{mean:.1} +- {sd:.1}"));
            tell.say(format!("ln of the Bayes factor by the plan: {first} if the first model is right, {second} if the second is"));
        }
        if let (Some([now, then]), Some(about)) = (self.quantity_sd, about) {
            tell.say(format!("Growth rate at {about}: sd {now:.3} 1/s now, {then:.3} 1/s after the plan"));
        }
        if let Some((point, nats)) = &self.further {
            let nats = fixed(*nats, 3);
            tell.say(format!("After it, the best further point would add {nats} nats: {point}"));
        }
    }
}

impl MicrophoneTable {
    /// Says what is lost without each microphone, and what others would add.
    pub fn tell(&self, tell: &dyn Tell) {
        let ([bare, all], points) = (self.total, self.points.len());
        tell.say(format!(
        "{}: measuring all {points} points once more gives an expected {bare:.3} nats by growth rates and frequencies",
        self.stage
    ));
        tell.say(format!("With the pressures of the microphones in use it gives {all:.3} nats"));
        let row = |m: &MicrophoneChoice| {
            let role = m.takes_its_role.as_ref();
            let note = role.map(|other| format!(" (the reference: without it, {other} takes its role)"));
            let name = format!("{}{}", m.microphone, note.unwrap_or_default());
            vec![format!("{:.3}", m.nats), format!("{:.3}", m.at), name]
        };
        let head = |nats: &str, which: &str| [nats, "x (m)", which].map(str::to_owned).to_vec();
        tell.table(head("nats lost", "microphone in use"), self.in_use.iter().map(row).collect());
        tell.table(
            head("nats added", "another microphone"),
            self.further.iter().take(SHOWN).map(row).collect(),
        );
        if self.further.len() > SHOWN {
            tell.say(format!("  and {} more", self.further.len() - SHOWN));
        }
        for (point, why) in self.left_out.iter().take(SHOWN) {
            tell.note(format!("{point} is left out: {why}"));
        }
        if !self.further.first().is_some_and(|m| m.nats >= self.worth) {
            tell.say(format!(
                "None is worth adding: each brings less than {} nats at these points",
                self.worth
            ));
        }
    }
}
