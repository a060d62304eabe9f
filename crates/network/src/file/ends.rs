//! Ends of the tube.

use super::assembly::Assembly;
use super::error::FileError;
use super::item::Item;
use super::odd::{growing, matched, thick_wall, turned};
use super::problem::ElementProblem;
use super::ranges::{blown_through, drawn_in};
use super::schema::Transfer;
use super::sizes::Sizes;
use super::warning::Warning;
use crate::laws::{Law, choked_inlet, choked_outlet, thick_wall_correction};
use crate::plane::region::Region;
use rijke_numerics::C64;
use serde::Deserialize;
use std::f64::consts::PI;

/// The ends.
#[derive(Debug, Deserialize)]
#[serde(tag = "type", rename_all = "kebab-case", deny_unknown_fields)]
enum End {
    // With braces, or keys that they do not have would be passed over.
    Open {},
    Closed {},
    Anechoic {},
    /// Constant R; angle in rad.
    Constant {
        modulus: f64,
        angle: f64,
    },
    /// R = modulus e^{-s delay}, with sign.
    Delayed {
        factor: f64,
        delay: f64,
    },
    Unflanged {
        /// m; thin if absent.
        #[serde(default)]
        wall_thickness: f64,
        /// Calibration: R is multiplied by modulus e^{i angle}.
        calibration: Option<[f64; 2]>,
    },
    Flanged {},
    /// A compact choked nozzle; with mean flow its Mach number follows.
    Choked {
        mach: Option<f64>,
    },
    /// Normalised impedance p/(rho c u) into the end.
    Impedance {
        #[serde(default = "super::schema::unity")]
        numerator: Vec<f64>,
        #[serde(default = "super::schema::unity")]
        denominator: Vec<f64>,
        #[serde(default)]
        delay: f64,
        table: Option<Vec<[f64; 3]>>,
        #[serde(default = "super::schema::fit")]
        tolerance: f64,
    },
    /// R itself, rational in s.
    Rational {
        numerator: Vec<f64>,
        denominator: Vec<f64>,
        #[serde(default)]
        delay: f64,
    },
    /// R itself, from a table, times gain e^{-s delay}.
    Table {
        table: Vec<[f64; 3]>,
        #[serde(default = "super::schema::fit")]
        tolerance: f64,
        #[serde(default = "super::schema::one")]
        gain: f64,
        #[serde(default)]
        delay: f64,
    },
}

impl Assembly<'_> {
    /// The law of the upstream (0) or downstream (1) end, and whether it is choked. `mach` is that of a mean
    /// flow.
    pub(super) fn end(
        &mut self,
        item: Item,
        table: toml::Table,
        end: usize,
        mach: Option<f64>,
        region: &Region,
    ) -> Result<(usize, bool), FileError> {
        let segment = self.segments[if end == 0 { 0 } else { self.segments.len() - 1 }];
        let (radius, sound_speed) = ((segment.area / PI).sqrt(), segment.sound_speed);
        let constant = |r: f64| Law::Constant(C64::new(r, 0.0));
        let function = |delay, numerator: &[f64], denominator: &[f64]| Transfer {
            gain: 1.0,
            delay,
            cutoff_hz: None,
            numerator: numerator.to_vec(),
            denominator: denominator.to_vec(),
            table: None,
            tolerance: 1e-6,
        };
        let mut choked = false;
        let mut is_mouth = false;
        let delay =
            table.get("delay").and_then(|v| v.as_float().or_else(|| v.as_integer().map(|v| v as f64)));
        let said_nothing = table.len() == 1;
        let law = match item.parse(table)? {
            End::Open {} => {
                is_mouth = true;
                constant(-1.0)
            }
            End::Closed {} => {
                self.warnings.extend(mach.map(|mach| blown_through(&item, mach, end)));
                constant(1.0)
            }
            End::Anechoic {} => constant(0.0),
            End::Constant { modulus, angle } => {
                item.not_negative("modulus", modulus)?;
                if angle.is_nan() || angle.abs() > 2.0 * std::f64::consts::PI {
                    return Err(item.fail(ElementProblem::Angle { key: "angle", value: angle }));
                }
                Law::Constant(C64::from_polar(modulus, angle))
            }
            End::Delayed { factor, delay } => {
                let shape = Transfer { gain: factor, ..function(delay, &[1.0], &[1.0]) };
                self.function(&item, &shape, 1.0)?
            }
            End::Unflanged { wall_thickness, calibration } => {
                is_mouth = calibration.is_none();
                self.unflanged(&item, [radius, sound_speed], wall_thickness, calibration)?
            }
            End::Flanged {} => {
                is_mouth = true;
                Law::Flanged { radius, sound_speed }
            }
            End::Choked { mach: given } => {
                choked = true;
                constant(self.nozzle(&item, end, [given, mach])?)
            }
            End::Impedance { numerator, denominator, delay, table, tolerance } => {
                let shape = Transfer { table, tolerance, ..function(delay, &numerator, &denominator) };
                self.warnings.extend(said_nothing.then(|| matched(&item)));
                Law::Impedance(Box::new(self.function(&item, &shape, 1.0)?))
            }
            End::Rational { numerator, denominator, delay } => {
                self.warnings.extend(growing(&item, &numerator, &denominator, None));
                self.function(&item, &function(delay, &numerator, &denominator), 1.0)?
            }
            End::Table { table, tolerance, gain, delay } => {
                self.warnings.extend(Warning::of_table(&item, &table, false));
                let shape =
                    Transfer { gain, table: Some(table), tolerance, ..function(delay, &[1.0], &[1.0]) };
                self.function(&item, &shape, 1.0)?
            }
        };
        let sizes = Sizes::of(self.gas, region);
        self.warnings.extend(delay.and_then(|delay| sizes.late(&item, delay)));
        // Where the flow leaves, a passive end gives back up to (1 + M)/(1 - M) of the pressure (Cantrell &
        // Hart, J. Acoust. Soc. Am. 36 (1964) 697).
        let most = mach.filter(|_| end == 1).map_or(1.0, |m| (1.0 + m) / (1.0 - m));
        self.check_modulus(&item, &law, region, most);
        self.warnings.extend(mach.filter(|_| is_mouth && end == 0).map(|mach| drawn_in(&item, mach)));
        Ok((self.laws.push(item.place, law), choked))
    }

    /// R of an unflanged end of this radius (m) and speed of sound (m/s).
    fn unflanged(
        &mut self,
        item: &Item,
        [radius, sound_speed]: [f64; 2],
        wall_thickness: f64,
        calibration: Option<[f64; 2]>,
    ) -> Result<Law, FileError> {
        let thickness = item.not_negative("wall_thickness", wall_thickness)?;
        self.warnings.extend(thick_wall(item, thickness, radius));
        let correction = thick_wall_correction(radius, thickness);
        let law = Law::Unflanged { radius, sound_speed, correction };
        let Some([modulus, angle]) = calibration else { return Ok(law) };
        item.positive("calibration", modulus)?;
        self.warnings.extend(turned(item, angle));
        Ok(Law::Scaled(Box::new(law), C64::from_polar(modulus, angle)))
    }

    /// R of a compact choked nozzle at an end, whose Mach number is given or that of a mean flow.
    fn nozzle(&self, item: &Item, end: usize, mach: [Option<f64>; 2]) -> Result<f64, FileError> {
        let mach = match mach {
            [Some(given), None] => item.positive("mach", given)?,
            [None, Some(of_flow)] => of_flow,
            _ => return Err(item.fail(ElementProblem::OneOf { one: "mach", other: "[flow]" })),
        };
        if mach >= 0.3 {
            return Err(item.fail(ElementProblem::TooFast { mach }));
        }
        let closure = if end == 0 { choked_inlet } else { choked_outlet };
        Ok(closure(self.gases[if end == 0 { 0 } else { self.gases.len() - 1 }].gamma, mach))
    }

    /// Warns of an end whose |R| exceeds what a passive one has at `most`, at a frequency of the search.
    fn check_modulus(&mut self, item: &Item, law: &Law, region: &Region, most: f64) {
        const SAMPLES: usize = 201;
        let [low, high] = region.omega.map(|w| w.max(1e-3));
        let omega = |k: usize| low + (high - low) * k as f64 / (SAMPLES - 1) as f64;
        let modulus = |k: usize| (law.analytic(C64::new(0.0, omega(k)))[0].norm(), omega(k));
        let largest = (0..SAMPLES).map(modulus).fold((0.0, low), |a, b| if b.0 > a.0 { b } else { a });
        self.passive &= largest.0 <= 1.0 + 1e-9;
        if largest.0 > most + 1e-9 {
            let frequency_hz = largest.1 / (2.0 * PI);
            let (line, place) = (item.line, item.place.clone());
            self.warnings.push(Warning::Reflection { line, place, modulus: largest.0, frequency_hz });
        }
    }
}
