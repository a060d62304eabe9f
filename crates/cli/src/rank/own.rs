//! Candidates of the user's own: read, tried, and found fit to compete with those of the project.

use crate::{
    candidate::examine,
    check::stages::teaches,
    failure::{Classify, Failure},
    ui::Ui,
};
use rijke_candidates::{Candidate, Catalogue};
use rijke_rig::{OperatingPoint, Rig};
use rijke_studies::{COMPETING_ROLES, ProngModel, catalogue};
use std::path::PathBuf;

/// Reads the files and checks that every candidate can compete on these operating points, before anything is trained.
pub(crate) fn candidates(
    files: &[PathBuf],
    rig: &Rig,
    points: &[OperatingPoint],
) -> Result<Vec<Candidate>, Failure> {
    let project = catalogue().or_failed()?;
    let mut own = Catalogue::default();
    for file in files {
        let read = Catalogue::read(file)
            .or_bad_input()
            .map_err(|f| f.remedy("`rijke candidate --symbols` lists what a formula may name."))?;
        for candidate in read.candidates() {
            let at = |message: String| {
                let (file, line) = read.place(&candidate.id).unwrap_or(("", 0));
                Failure::bad_input(format!("{file}, line {line}: {message}"))
            };
            if !COMPETING_ROLES.contains(&candidate.role.as_str()) {
                let (id, role) = (&candidate.id, &candidate.role);
                return Err(at(format!(
                    "`{id}` has the role `{role}`, in which `rijke rank` compares nothing"
                ))
                .remedy(format!("Give it one of the roles {}.", COMPETING_ROLES.join(", "))));
            }
            let others = || project.candidates().iter().chain(own.candidates());
            if others().any(|c| c.id == candidate.id) {
                return Err(at(format!("another candidate is called `{}` already", candidate.id))
                    .remedy(format!("Give it another id; those of the project are {}.", ids(&project))));
            }
            if let Some((other, name)) = others().find_map(|c| shared(candidate, c)) {
                return Err(at(format!(
                    "the parameter `{name}` of `{}` is also one of `{other}`, with which it acts together",
                    candidate.id
                ))
                .remedy("Rename the parameter: candidates of different roles must not share a name."));
            }
            // What nothing was measured of does not compete.
            if !points.iter().any(|point| teaches(&candidate.role, point)) {
                continue;
            }
            if let Some(fault) = examine(candidate, rig, points).faults.first() {
                return Err(at(format!("`{}`: {fault}", candidate.id)).remedy(format!(
                    "Correct it; `rijke candidate {}` lists all that is wrong.",
                    file.display()
                )));
            }
        }
        own = own.joined(read);
    }
    Ok(own.candidates().to_vec())
}

fn ids(catalogue: &Catalogue) -> String {
    catalogue.candidates().iter().map(|c| c.id.as_str()).collect::<Vec<_>>().join(", ")
}

/// The name of a parameter that two candidates have which can be parts of one model. The heater at work takes the place of
/// the cold one.
fn shared<'a>(one: &'a Candidate, other: &'a Candidate) -> Option<(&'a str, &'a str)> {
    let part = |c: &'a Candidate| c.role.strip_prefix("hot-").unwrap_or(&c.role);
    let same = |name: &&str| other.parameters.iter().any(|p| p.name == **name);
    let name = one.parameters.iter().map(|p| p.name.as_str()).find(same)?;
    (part(one) != part(other)).then_some((other.id.as_str(), name))
}

/// Says where each candidate of the user's own stands in a table whose evidences are per operating point, of which there are
/// `points`.
pub(super) fn standing(ui: &Ui, models: &[ProngModel], points: usize, own: &[Candidate]) {
    let total = |m: &ProngModel| m.evidence.map(|e| e.ln_marginal * points as f64);
    let mine = |m: &ProngModel| own.iter().any(|c| m.id.split(" + ").next() == Some(&c.id));
    let count = models.iter().filter(|m| m.evidence.is_some()).count();
    for model in models.iter().filter(|m| mine(m)) {
        let Some(ln) = total(model) else { continue };
        let others = || models.iter().filter(|m| m.id != model.id).filter_map(|m| Some((m, total(m)?)));
        let place = 1 + others().filter(|(_, other)| *other > ln).count();
        let Some((best, other)) = others().max_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
        let side = if ln < other { "below" } else { "above" };
        ui.say(format!(
            "yours: {}: place {place} of {count}, {:.1} nats {side} {}",
            model.id,
            (ln - other).abs(),
            best.id
        ));
    }
}

/// Says which candidates of the user's own did not compete, because what they need was not measured or not given.
pub(super) fn left_out(ui: &Ui, own: &[Candidate], ranked: &[&str]) {
    for candidate in own.iter().filter(|c| !ranked.contains(&c.role.as_str())) {
        let need = match candidate.role.as_str() {
            "heat-release" => "hot points with their base flow (--flow)",
            _ => "points with a cold heater and no thermocouples",
        };
        ui.note(format!("{} is not ranked: it needs {need}", candidate.id));
    }
}
