//! What a stage lacks a law for, parts and ends; errors that its noise does not have, and noise that does not
//! count.

use super::{Base, Plan, Stage};
use crate::law::{Effect, Place};
use crate::source::listed;
use crate::{Campaign, Candidate, Catalogue, Point, Rig, StudyProblem, rig::Shape};
use rijke_numerics::words::counted;
use std::collections::BTreeSet;

impl Plan {
    /// The parts that a factor puts into the rig at points of a stage in which no law acts on them, each in a
    /// sentence.
    pub(crate) fn lawless(&self, rig: &Rig, campaign: &Campaign, catalogue: &Catalogue) -> Vec<String> {
        let mut said = Vec::new();
        for stage in &self.stages {
            let effects = self.effects_of(stage, rig, catalogue);
            let moved: BTreeSet<usize> = effects.filter_map(|e| e.place.part()).collect();
            let idle = rig.parts.iter().enumerate().filter(|(k, part)| {
                matches!(part.shape, Shape::Device(_) | Shape::Insert(..)) && !moved.contains(k)
            });
            for (part, factor) in idle.filter_map(|(_, part)| Some((part, rig.presence(part)?))) {
                let there = campaign.points.iter().filter(|p| stage.points.holds(campaign, p));
                let count = there.filter(|p| p.factors[factor] > 0.0).count();
                if count > 0 {
                    said.push(format!(
                        "study.toml: `{}` is in the rig at {} of stage `{}` (`{}` is not 0), and no candidate of that stage acts on it: there \
                         it counts as absent; name a role of its candidates, or leave these points out",
                        part.name,
                        counted(count, "point"),
                        stage.id,
                        campaign.factors[factor].name
                    ));
                }
            }
        }
        said
    }

    /// Refuses a stage of modes in which nothing says what an end reflects.
    pub(super) fn ends_have_laws(
        &self,
        stage: &Stage,
        rig: &Rig,
        catalogue: &Catalogue,
    ) -> Result<(), StudyProblem> {
        for (end, name) in [(Place::Upstream, "upstream"), (Place::Downstream, "downstream")] {
            let acts = |e: &Effect| e.place == end || e.place == Place::Ends;
            if self.effects_of(stage, rig, catalogue).any(acts) {
                continue;
            }
            let able = catalogue.candidates().iter().filter(|c| c.effects.iter().any(acts));
            let roles: BTreeSet<&str> = able.map(|c| &*c.role).collect();
            let remedy = match roles.len() {
                0 => "write a candidate with acts_at at that end".to_owned(),
                _ => format!("name {} in `compete` or `with`, or a stage that has it in `on`", listed(roles)),
            };
            return Err(StudyProblem::FreeEnd { stage: stage.id.clone(), end: name, remedy });
        }
        Ok(())
    }

    /// Noise of stages that counts only with `base_errors`, where they do without, each in a sentence.
    pub(crate) fn idle_noise(&self, campaign: &Campaign) -> Vec<String> {
        let mut said = Vec::new();
        let without = || self.stages.iter().filter(|s| !s.base_errors);
        for stage in without() {
            let declared = [
                ("law", "the error of a law", stage.noise.law.is_some()),
                ("installation", "what points of one installation share", stage.noise.installation.is_some()),
            ];
            said.extend(declared.into_iter().filter(|(.., there)| *there).map(|(key, what, _)| {
                format!(
                    "study.toml: `noise.{key}` of stage `{}` has no effect, because {what} counts only with `base_errors = true`",
                    stage.id
                )
            }));
            if !stage.noise.varying.is_empty() && shares_an_installation(campaign, stage) {
                said.push(format!(
                    "study.toml: `noise.varying` of stage `{}` is drawn for every mode by itself: with `base_errors = true` all modes of one \
                     installation share it",
                    stage.id
                ));
            }
        }
        if !matches!(self.base, Base::Ambient | Base::Rig) {
            return said;
        }
        let unsure = |p: &Point| p.ambient.is_some_and(|[_, sd]| sd > 0.0);
        let takes = |s: &&Stage| campaign.points.iter().any(|p| unsure(p) && s.points.holds(campaign, p));
        let stages: Vec<String> = without().filter(takes).map(|s| format!("`{}`", s.id)).collect();
        if !stages.is_empty() {
            said.push(format!(
                "study.toml: T_amb_sd does not count in stages without `base_errors = true` ({}): they take the temperature of the gas for exact",
                stages.join(", ")
            ));
        }
        said
    }

    /// What acts in the models of a stage: effects of the candidates of its roles, and of the rig itself.
    pub(super) fn effects_of<'a>(
        &'a self,
        stage: &'a Stage,
        rig: &'a Rig,
        catalogue: &'a Catalogue,
    ) -> impl Iterator<Item = &'a Effect> {
        let roles = self.roles_of(stage, catalogue);
        let laws = catalogue.candidates().iter().filter(move |c| roles.contains(&*c.role));
        laws.chain([&rig.own]).flat_map(|c| &c.effects)
    }

    /// The tables whose stated error is in no noise of a stage that weighs them, each in a sentence.
    pub(crate) fn tolerated(&self, catalogue: &Catalogue) -> Vec<String> {
        let mut said = Vec::new();
        for stage in &self.stages {
            let counts = |role: &String| stage.noise.law.as_ref().is_some_and(|law| law.role == *role);
            let named = |c: &Candidate| {
                let listed = stage.among.is_empty() || stage.among.contains(&c.id);
                (stage.compete.contains(&c.role) && listed)
                    || stage.with.get(&c.role) == Some(&c.id)
                    || stage.rows.iter().flatten().any(|id| *id == c.id)
            };
            for c in catalogue.candidates().iter().filter(|c| named(c) && !counts(&c.role)) {
                said.extend(c.tolerance.map(|tolerance| {
                    // A tolerance is twice the error.
                    format!(
                        "study.toml: the table of `{}` may be off by {tolerance} of its largest gain, as its `tolerance` says, and stage `{}` takes it \
                         for exact: for an error of the law write law = {{ role = \"{}\", sd = {}, over = \"FACTOR\" }} in [stage.noise], with \
                         base_errors = true",
                        c.id,
                        stage.id,
                        c.role,
                        0.5 * tolerance
                    )
                }));
            }
        }
        said
    }

    /// The roles of the candidates that are part of a model of a stage.
    fn roles_of<'a>(&'a self, stage: &'a Stage, catalogue: &'a Catalogue) -> BTreeSet<&'a str> {
        let mut roles = BTreeSet::new();
        for id in &stage.on {
            match self.stage(id) {
                Some((_, other)) => roles.extend(self.roles_of(other, catalogue)),
                None => self.roles_of_response(id, &mut roles),
            }
        }
        roles.retain(|role| stage.without.iter().all(|other| other != role));
        roles.extend(stage.with.keys().chain(&stage.compete).map(String::as_str));
        let of_rows = stage.rows.iter().flatten().filter_map(|id| catalogue.get(id));
        roles.extend(of_rows.map(|c| &*c.role));
        roles
    }

    fn roles_of_response<'a>(&'a self, id: &str, roles: &mut BTreeSet<&'a str>) {
        let Some(stage) = self.response(id) else { return };
        roles.extend(stage.with.keys().chain(&stage.compete).map(String::as_str));
        stage.on.iter().for_each(|id| self.roles_of_response(id, roles));
    }
}

/// Whether two points of a stage share an assembly of the rig.
fn shares_an_installation(campaign: &Campaign, stage: &Stage) -> bool {
    let points: Vec<&Point> = campaign.points.iter().filter(|p| stage.points.holds(campaign, p)).collect();
    let same = |a: &Point, b: &Point| !a.installation.is_empty() && a.installation == b.installation;
    (0..points.len()).any(|k| points[..k].iter().any(|p| same(p, points[k])))
}
