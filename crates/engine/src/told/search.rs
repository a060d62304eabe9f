//! What is said and tabled of a search.

use super::doubts::reasons;
use crate::run::SearchRecord;
use rijke_numerics::Tell;

/// Rows that are said; the tables have all.
const SHOWN: usize = 12;

impl SearchRecord {
    /// The roles in which combinations differ.
    pub fn roles(&self) -> Vec<&str> {
        self.choices.iter().map(|c| &*c.role).collect()
    }

    /// Combinations, best first: a head, then rows.
    pub fn combinations_table(&self) -> Vec<Vec<String>> {
        let roles = self.roles();
        let best = self.best.first().map_or(0.0, |c| c.ln_evidence);
        let head = ["rank", "ln_evidence", "behind", "probability"].into_iter().chain(roles.iter().copied());
        let head = head.chain(self.stages.iter().map(String::as_str));
        let mut rows = vec![head.map(str::to_owned).collect::<Vec<String>>()];
        for (k, c) in self.best.iter().enumerate() {
            let numbers = [c.ln_evidence, best - c.ln_evidence, c.probability];
            let named = roles.iter().map(|role| c.candidates.get(*role).cloned().unwrap_or_default());
            let row = std::iter::once((k + 1).to_string()).chain(numbers.map(|v| v.to_string())).chain(named);
            rows.push(row.chain(c.stages.iter().map(f64::to_string)).collect());
        }
        rows
    }

    /// Candidates of every role with their probabilities: a head, then rows.
    pub fn choices_table(&self) -> Vec<Vec<String>> {
        let mut rows = vec![["role", "candidate", "probability"].map(str::to_owned).to_vec()];
        for choice in &self.choices {
            rows.extend(
                choice.candidates.iter().map(|(id, p)| vec![choice.role.clone(), id.clone(), p.to_string()]),
            );
        }
        rows
    }

    /// How many combinations were given up before the end.
    fn left(&self) -> usize {
        self.given_up.iter().map(|g| g.combinations).sum()
    }

    /// How many hold a model that could not be fitted.
    fn lost(&self) -> usize {
        self.not_fitted.iter().map(|g| g.combinations).sum()
    }

    /// Says how many combinations there are, which are the best, and what else is found.
    pub fn tell(&self, tell: &dyn Tell) {
        self.tell_counts(tell);
        let roles = self.roles();
        let best = self.best.first().map_or(0.0, |c| c.ln_evidence);
        let greedy = self.greedy.rank.unwrap_or(0);
        let shown = self.best.iter().enumerate().filter(|(k, _)| *k < SHOWN || k + 1 == greedy);
        let rows = shown.map(|(k, c)| {
            let names: Vec<&str> =
                roles.iter().filter_map(|role| c.candidates.get(*role).map(String::as_str)).collect();
            let mark = if k + 1 == greedy { "  <- stage by stage" } else { "" };
            let [nats, odds] = [format!("{:.1}", c.ln_evidence - best), format!("{:.4}", c.probability)];
            vec![nats, odds, format!("{}{mark}", names.join(" + "))]
        });
        tell.table(["nats", "probability", "combination"].map(str::to_owned).to_vec(), rows.collect());
        self.tell_rest(tell);
    }

    /// Says how many combinations there are.
    fn tell_counts(&self, tell: &dyn Tell) {
        let (left, lost) = (self.left(), self.lost());
        tell.say(format!(
            "{} combinations over {}: {} trained completely, {left} pruned, {lost} could not be fitted; {} of {} models trained",
            self.combinations,
            self.stages.join(", "),
            self.best.len(),
            self.models_trained,
            self.models
        ));
    }

    /// Says what is found besides the table of combinations.
    fn tell_rest(&self, tell: &dyn Tell) {
        let (left, lost) = (self.left(), self.lost());
        for remark in self.best.first().into_iter().flat_map(|c| reasons(&c.remark)) {
            tell.say(format!("the first: {remark}"));
        }
        for choice in &self.choices {
            let shown =
                |(id, p): &(String, f64)| format!("{} {p:.4}", if id.is_empty() { "none" } else { id });
            let likely = choice.candidates.iter().take(4).map(shown).collect::<Vec<_>>().join(", ");
            tell.say(format!("{}: {likely}", choice.role));
        }
        let g = &self.greedy;
        tell.say(match g.rank {
            Some(rank) => format!(
                "stage by stage: place {rank} of {}, probability {:.4}, {:.1} nats behind the best",
                self.best.len(),
                g.probability,
                g.behind.unwrap_or_default()
            ),
            None => {
                "stage by stage: the choice made stage by stage could not be fitted in all stages".to_owned()
            }
        });
        if let Some(within) = self.within.filter(|_| left > 0) {
            tell.say(format!(
                "pruning at {within} nats discards at most {:.1e} of the probability, provided that no pruned model gains more in later stages than those that \
                 were followed (docs/search.md)",
                self.given_up_at_most
            ));
        }
        if let Some(first) = self.not_fitted.first() {
            let named = first.candidates.values().cloned().collect::<Vec<_>>().join(" + ");
            tell.note(format!(
                "warning: {lost} combinations hold a model that could not be fitted, first {named} at {}: {}",
                first.stage,
                first.remark.as_deref().unwrap_or_default()
            ));
        }
    }
}
