//! The modes of a case: counted, each with the parts of its growth rate.

use super::case::{Given, ModeCase};
use crate::ModeDetails;
use rijke_network::file::{Account, Actors, Scatter, by_the_rule_of_oscilos, moved_by_pieces, scatter};
use rijke_network::{Advice, Constant, Mode, Modes};
use rijke_numerics::{C64, Classify, Failed, Tell};
use rijke_rig::files::csv_table;
use serde::Serialize;
use std::f64::consts::PI;

/// All modes of a case.
#[derive(Clone, Debug, Serialize)]
pub struct FoundModes {
    /// Of the case.
    pub name: Option<String>,
    /// How many there are by a contour integral.
    pub counted: usize,
    /// How many were found.
    pub found: usize,
    /// Poles of laws in the region, told apart from modes.
    pub poles: usize,
    /// The modes.
    pub modes: Vec<ModeLine>,
    /// Where small changes would stabilise them most, where it was asked for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sensitivity: Vec<Advice>,
    /// The modes as the network has them.
    #[serde(skip)]
    pub all: Vec<Mode>,
}

/// One mode. Shares of the growth rate are half the power over the energy of the mode; they add up
/// to it.
#[derive(Clone, Debug, Serialize)]
pub struct ModeLine {
    /// Imaginary part of the eigenvalue over 2 pi, Hz.
    pub frequency_hz: f64,
    /// Its real part, 1/s; below zero where the mode decays.
    pub growth_rate: f64,
    /// Estimate of the error of the eigenvalue, relative to its modulus.
    pub residual: f64,
    /// How much relative errors of the chain's numbers are magnified in s.
    pub condition: f64,
    /// How often it is a mode.
    pub multiplicity: usize,
    /// Share of the upstream end in the growth rate, 1/s.
    pub by_upstream_end: f64,
    /// Share of the downstream end, 1/s.
    pub by_downstream_end: f64,
    /// Share of the friction at the walls, 1/s.
    pub by_viscous_loss: f64,
    /// Share of the heat that the walls take, 1/s.
    pub by_thermal_loss: f64,
    /// Elements and laws by name, and the share of each, 1/s.
    pub by_elements: Vec<(String, f64)>,
    /// Frequency (Hz) and growth rate (1/s) by OSCILOS_lite's own rule for open ends.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by_the_rule_of_oscilos: Option<[f64; 2]>,
    /// What the noise of measured tables does to it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by_noise_of_tables: Option<ByNoise>,
    /// By how much its frequency (Hz) and growth rate (1/s) move in twice as many pieces of slopes, cones and
    /// spread flames, where the network has such.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by_twice_as_many_pieces: Option<[f64; 2]>,
}

/// What the noise of measured tables does to a mode.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ByNoise {
    /// Standard deviation, Hz.
    pub frequency_sd_hz: f64,
    /// 1/s.
    pub growth_rate_sd: f64,
    /// In how many draws of the tables, of how many, there is such a mode.
    pub found: usize,
    /// Of so many.
    pub draws: usize,
    /// Whether it may be a mode of the fit alone.
    pub doubtful: bool,
}

/// Tables whose rows a fit meets better than this, of their largest value, are no measurements.
const NOISE: f64 = 1e-4;

impl ModeCase {
    /// Finds them. What is doubtful is told: it may say why there are no modes.
    pub fn find(&self, tell: &dyn Tell) -> Result<FoundModes, Failed> {
        let path = self.path.display();
        self.warnings.iter().for_each(|warning| tell.note(format!("warning: {path}: {warning}")));
        let found = self.modes()?;
        let mut lines = found.modes.iter().map(|mode| self.line(mode)).collect::<Result<Vec<_>, _>>()?;
        for (line, by) in lines.iter_mut().zip(self.by_noise(&found)?) {
            line.by_noise_of_tables = Some(by);
            if by.doubtful {
                tell.note(format!(
                    "warning: {path}: the mode at {:.2} Hz may be one of the noise of a measured table: of {} tables drawn with that noise {} have it; look \
                     whether the tolerance is two to three times the error of a row, and measure more rows there",
                    line.frequency_hz, by.draws, by.found
                ));
            }
        }
        for (line, by) in lines.iter_mut().zip(self.by_pieces(&found)?) {
            line.by_twice_as_many_pieces = by.map(|by| [by.im / (2.0 * PI), by.re]);
            if by.is_none() {
                tell.note(format!(
                    "warning: {path}: the mode at {:.2} Hz is not there in twice as many pieces of slopes, cones and spread flames: give these ducts and \
                     flames more `pieces`",
                    line.frequency_hz
                ));
            }
        }
        self.note.iter().for_each(|note| tell.note(note.clone()));
        if let Some(growing) =
            lines.iter().find(|l| self.passive && l.growth_rate > 1e-9 * l.frequency_hz.abs())
        {
            tell.note(format!(
                "warning: {path}: the mode at {:.2} Hz grows although nothing in the file feeds energy: an end or a \
                 coefficient of it is not what it should be (see the column that is positive)",
                growing.frequency_hz
            ));
        }
        Ok(FoundModes {
            name: self.title.clone(),
            counted: found.counted,
            found: found.modes.iter().map(|m| m.multiplicity).sum(),
            poles: found.poles,
            modes: lines,
            sensitivity: Vec::new(),
            all: found.modes,
        })
    }

    /// Everything about one mode that a line of the table holds.
    fn line(&self, mode: &Mode) -> Result<ModeLine, Failed> {
        let mut ruled = None;
        let account = match &self.given {
            Given::File(built, _) => built.account(mode),
            Given::Oscilos(chain, names) => {
                ruled = by_the_rule_of_oscilos(chain, mode.s).or_failed()?;
                Account::of(&**chain, &Constant, Actors::AtPlaces(names), &mode.root())
            }
            Given::Point(spectrum) => Ok(spectrum.of(mode).map_or_else(Account::default, account)),
        }
        .or_failed()?;
        Ok(ModeLine {
            frequency_hz: mode.s.im / (2.0 * PI),
            growth_rate: mode.s.re,
            residual: mode.residual,
            condition: account.condition,
            multiplicity: mode.multiplicity,
            by_upstream_end: account.upstream,
            by_downstream_end: account.downstream,
            by_viscous_loss: account.viscous,
            by_thermal_loss: account.thermal,
            by_elements: account.elements,
            by_the_rule_of_oscilos: ruled.map(|s| [s.im / (2.0 * PI), s.re]),
            by_noise_of_tables: None,
            by_twice_as_many_pieces: None,
        })
    }

    /// By how much each mode moves in twice as many pieces; nothing where no pieces stand for what varies.
    fn by_pieces(&self, modes: &Modes) -> Result<Vec<Option<C64>>, Failed> {
        let Given::File(built, text) = &self.given else { return Ok(Vec::new()) };
        if !built.in_pieces {
            return Ok(Vec::new());
        }
        let places: Vec<C64> = modes.modes.iter().map(|mode| mode.s).collect();
        moved_by_pieces(text, &places).or_bad_input().map_err(|failure| failure.at(&self.path))
    }

    /// What the noise of measured tables does to each mode; nothing where no table of a network file has any.
    fn by_noise(&self, modes: &Modes) -> Result<Vec<ByNoise>, Failed> {
        let Given::File(built, text) = &self.given else { return Ok(Vec::new()) };
        if built.noise() <= NOISE {
            return Ok(Vec::new());
        }
        let places: Vec<C64> = modes.modes.iter().map(|mode| mode.s).collect();
        let all = scatter(text, built, &places).or_bad_input().map_err(|failure| failure.at(&self.path))?;
        let by = |s: &Scatter| ByNoise {
            frequency_sd_hz: s.sd[1] / (2.0 * PI),
            growth_rate_sd: s.sd[0],
            found: s.found,
            draws: s.draws,
            doubtful: s.is_doubtful(),
        };
        Ok(all.iter().map(by).collect())
    }
}

impl FoundModes {
    /// As CSV.
    pub fn csv(&self) -> Result<String, Failed> {
        let head = "frequency [Hz],growth_rate [1/s],residual,condition,multiplicity,upstream_end [1/s],\
             downstream_end [1/s],viscous_wall [1/s],thermal_wall [1/s],elements [1/s]";
        let head = head.split(',').map(str::to_owned).collect();
        let row = |l: &ModeLine| {
            let [frequency, growth] = [l.frequency_hz, l.growth_rate].map(|v| v.to_string());
            let (residual, multiplicity) = (format!("{:e}", l.residual), l.multiplicity.to_string());
            let elements: f64 = l.by_elements.iter().map(|(_, v)| v).sum();
            let shares =
                [l.by_upstream_end, l.by_downstream_end, l.by_viscous_loss, l.by_thermal_loss, elements];
            [frequency, growth, residual, l.condition.to_string(), multiplicity]
                .into_iter()
                .chain(shares.map(|v| v.to_string()))
                .collect()
        };
        csv_table(std::iter::once(head).chain(self.modes.iter().map(row)))
    }
}

/// The parts of the growth rate of a mode of a study.
fn account(found: &ModeDetails) -> Account {
    let b = &found.budget;
    let flow = Some(("mean flow".to_owned(), 0.5 * b.mean_flow)).filter(|(_, share)| *share != 0.0);
    Account {
        condition: found.condition,
        upstream: 0.5 * b.upstream,
        downstream: 0.5 * b.downstream,
        viscous: 0.5 * b.viscous,
        thermal: 0.5 * b.thermal,
        elements: found.laws.iter().cloned().chain(flow).collect(),
    }
}
