//! A candidate in Rust, for what a formula cannot say: heat that is released after delays read from a measured histogram.
//!
//! `cargo run --release -p rijke-model --example your_own_candidate`
#![allow(clippy::print_stdout, reason = "an example shows what it finds")]

use rijke_candidates::{Candidate, Catalogue, Coefficient, Effect, Here, Law, Place, Symbol};
use rijke_inference::{Parameter, Prior};
use rijke_model::{Assembly, Conditions, ModelError, PointModel, Workspace};
use rijke_numerics::{C64, Jet, Order};
use rijke_rig::{Campaign, Rig};
use std::sync::Arc;

/// k_eu = -k Q_h sum over the histogram of weight e^{-s stretch delay}. Analytic in s, because every term is.
#[derive(Debug)]
struct Histogram {
    /// Weight (they add up to one) and delay in s.
    bars: Vec<[f64; 2]>,
}

impl Law for Histogram {
    fn evaluate(&self, here: &Here<'_>, parameters: &[Jet]) -> Jet {
        let [gain, stretch] = parameters else { return here.space.real(f64::NAN) };
        let power = here.surroundings.get(Symbol::Power).unwrap_or(f64::NAN);
        let zero = here.space.real(0.0);
        let response = self.bars.iter().fold(zero, |sum, [weight, delay]| {
            let lag = &here.s.scale(C64::new(-delay, 0.0)) * stretch;
            &sum + &lag.exp().scale(C64::new(*weight, 0.0))
        });
        // First and second derivatives in gain, stretch and s come along by themselves.
        (gain * &response).scale(C64::new(-power, 0.0))
    }

    fn text(&self) -> String {
        format!("-gain*Q_h*(histogram of {} delays, stretched)", self.bars.len())
    }
}

fn candidate() -> Candidate {
    let bars = vec![[0.2, 2e-4], [0.5, 4e-4], [0.2, 7e-4], [0.1, 1.2e-3]];
    Candidate {
        id: "heat-release.histogram".into(),
        role: "heat-release".into(),
        name: "measured histogram of delays".into(),
        cite: vec!["own measurement".into()],
        note: String::new(),
        parameters: vec![
            Parameter::new("gain", "k", "1/W", Prior::Normal { mean: 1e-3, sd: 1e-3 }),
            Parameter::new("stretch", "a", "1", Prior::Normal { mean: 1.0, sd: 0.3 }),
        ],
        effects: vec![Effect {
            place: Place::Heater,
            coefficient: Coefficient::Eu,
            law: Arc::new(Histogram { bars }),
        }],
    }
}

/// The paper's tube at 180 W with the heater at 0.25 m, cold gas for simplicity: growth rate at two gains, and its slope.
fn study() -> Result<[f64; 3], Box<dyn std::error::Error>> {
    let rest = "[[candidate]]\nid = \"wall\"\nrole = \"wall\"\nname = \"Rayleigh\"\ncite = [\"section 6.1\"]\n[[candidate.effect]]\n\
                acts_at = \"tube\"\nmu = \"4/D*sqrt(s*rho*mu)\"\n[[candidate]]\nid = \"ends\"\nrole = \"ends\"\nname = \"open\"\n\
                cite = [\"Levine & Schwinger 1948\"]\n[[candidate.effect]]\nacts_at = \"both-ends\"\nreflection = \"R_LS\"\n";
    let mut candidates = Catalogue::from_toml(rest, "here")?.candidates().to_vec();
    candidates.push(candidate());
    let assembly = Assembly::new(Rig::juniper_yoko_2022(), candidates)?;
    let campaign = Campaign::juniper_yoko_2022();
    let point = campaign.points.into_iter().find(|p| p.id == "H180-25").ok_or("no such point")?;
    let conditions = Conditions::cold(&assembly.rig, point, 293.15, 0.0)?;
    let model = PointModel::new(&assembly, &conditions, &[assembly.rig.microphones.reference])?;
    let growth = |gain: f64| -> Result<[f64; 2], ModelError> {
        let s = model.respond(&[gain, 1.0], Order::First, &mut Workspace::default())?.s;
        Ok([s.value().re, s.gradient()[0].re])
    };
    let ([low, slope], [high, _]) = (growth(1.0e-3)?, growth(1.001e-3)?);
    Ok([low, slope, (high - low) / 1e-6])
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let [growth, slope, quotient] = study()?;
    println!("growth rate {growth:.3} 1/s; per unit of gain {slope:.1}, by differences {quotient:.1}");
    Ok(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn oracle_a_law_in_rust_has_exact_derivatives() {
        let [growth, slope, quotient] = super::study().unwrap();
        assert!(growth.is_finite() && slope.abs() > 1.0, "{growth} {slope}");
        assert!((quotient / slope - 1.0).abs() < 1e-3, "{slope} against {quotient}");
    }
}
