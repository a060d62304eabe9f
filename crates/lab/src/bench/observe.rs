//! From a truth file to observations with noise, and to files.

use super::base::Base;
use super::campaign;
use super::campaign::Point;
use super::chain::Chain;
use super::error::BenchError;
use super::modes::modes;
use super::truth::BenchTruth;
use crate::records::virtual_rig::normal;
use rayon::prelude::*;
use rijke_numerics::{C64, Streams};
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// A truth and its campaign, ready to be observed.
#[derive(Clone, Debug)]
pub struct Bench {
    path: PathBuf,
    truth: BenchTruth,
    points: Vec<Point>,
}

/// One mode of one operating point.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// The operating point.
    pub point: String,
    /// Its number at that point, from 1 for the lowest frequency.
    pub mode: usize,
    /// What is true: growth rate + i angular frequency.
    pub exact: C64,
    /// What is true of every source that is there: k_eu of equation (2) of Juniper & Yoko 2022 at `exact`.
    pub feedback: Vec<C64>,
    /// Growth rate with noise, 1/s.
    pub growth_rate: f64,
    /// Frequency with noise, Hz.
    pub frequency_hz: f64,
    /// Pressures relative to the reference with noise, in the order of the microphones; none for a dead one
    /// and for the reference.
    pub pressures: Vec<Option<C64>>,
}

/// What a thermometer shows.
#[derive(Clone, Debug, PartialEq)]
pub struct BenchReading {
    /// The operating point.
    pub point: String,
    /// Where, m from the upstream end.
    pub at: f64,
    /// K.
    pub temperature: f64,
    /// Its stated standard deviation, K.
    pub sd: f64,
}

/// All that was observed.
#[derive(Clone, Debug, PartialEq)]
pub struct BenchObservations {
    /// Modes, in the order of the campaign.
    pub modes: Vec<Measured>,
    /// Readings of thermometers, in the order of the campaign.
    pub readings: Vec<BenchReading>,
    source: String,
    /// Of growth rates, frequencies and relative pressures.
    sds: [f64; 3],
    /// Index of the reference microphone.
    reference: usize,
}

/// Reads a truth file and the campaign beside it, observes every point with the noise of `seed`, and writes
/// `modes.csv`, `observations.toml` and, where there are thermometers, `readings.csv` into the folder `out`.
///
/// # Errors
/// [`BenchError`], with the file and line or the operating point.
pub fn run(truth: &Path, out: &Path, seed: u64) -> Result<BenchObservations, BenchError> {
    let observations = Bench::read(truth)?.observe(seed)?;
    observations.write(out)?;
    Ok(observations)
}

impl Bench {
    /// Reads a truth file and the campaign beside it.
    ///
    /// # Errors
    /// A file that cannot be read or parsed, with its line.
    pub fn read(path: &Path) -> Result<Self, BenchError> {
        let truth = BenchTruth::read(path)?;
        let points = campaign::read(&path.with_file_name(&truth.campaign))?;
        Ok(Self { path: path.to_owned(), truth, points })
    }

    /// Observes every point with the noise of `seed`. The true temperature of the room differs from the
    /// stated one by the same draw at all points of a day.
    ///
    /// # Errors
    /// A factor without a value, a value out of range, a mode that was not found or that grows.
    pub fn observe(&self, seed: u64) -> Result<BenchObservations, BenchError> {
        let streams = Streams::new(seed);
        let each: Vec<_> = self.points.par_iter().map(|point| self.observe_point(point, streams)).collect();
        let noise = self.truth.noise;
        let file = self.path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let mut all = BenchObservations {
            modes: vec![],
            readings: vec![],
            source: format!("virtual laboratory, bench `{}`, {file}, seed {seed}", self.truth.name),
            sds: [noise.growth_rate, noise.frequency_hz, noise.pressure],
            reference: self.truth.microphones.reference - 1,
        };
        for point in each {
            let (modes, readings) = point?;
            all.modes.extend(modes);
            all.readings.extend(readings);
        }
        Ok(all)
    }

    /// A transfer function measured on its own: -k_eu at the frequencies `hz` over its value at rest, times
    /// the stated sensitivity, of the first source at the first point called `id`; rows of frequency in Hz,
    /// gain, and phase in rad that runs on. `sds` are relative, of the gain, and absolute, of the phase. None
    /// if there is no such source.
    ///
    /// # Errors
    /// As [`Bench::observe`].
    pub fn transfer(
        &self,
        id: &str,
        hz: &[f64],
        sds: [f64; 2],
        seed: u64,
    ) -> Result<Option<Vec<[f64; 3]>>, BenchError> {
        let Some(point) = self.points.iter().find(|point| point.id == id) else { return Ok(None) };
        let base = Base::new(&self.truth, point, point.ambient[0])?;
        let chain = Chain::new(&self.truth, point, &base)?;
        let at = |f: f64| chain.feedback(C64::new(0.0, TAU * f)).first().map(|k| -k);
        let (Some(rest), Some(source)) = (at(0.0), self.truth.source.first()) else { return Ok(None) };
        let sensitivity = source.sensitivity.as_ref().map_or(Ok(1.0), |value| value.at(point))?;
        let mut stream = Streams::new(seed).stream(&format!("bench/transfer/{id}"));
        let (mut phase, mut before) = (0.0, C64::ONE);
        let rows = hz.iter().filter_map(|f| {
            let here = at(*f)? / rest;
            phase += (here / before).arg();
            before = here;
            let gain = sensitivity * here.norm() * (1.0 + sds[0] * normal(&mut stream));
            Some([*f, gain, phase + sds[1] * normal(&mut stream)])
        });
        Ok(Some(rows.collect()))
    }

    fn observe_point(
        &self,
        point: &Point,
        streams: Streams,
    ) -> Result<(Vec<Measured>, Vec<BenchReading>), BenchError> {
        let day = if point.day.is_empty() { &point.id } else { &point.day };
        let ambient =
            point.ambient[0] + point.ambient[1] * normal(&mut streams.stream(&format!("bench/day/{day}")));
        let base = Base::new(&self.truth, point, ambient)?;
        let chain = Chain::new(&self.truth, point, &base)?;
        let roots = modes(&point.id, |s| chain.march(s).drive, self.truth.search)?;
        let mut stream = streams.stream(&format!("bench/noise/{}", point.id));
        let microphones = &self.truth.microphones;
        let (noise, reference) = (self.truth.noise, microphones.reference - 1);
        let mut measured = Vec::new();
        let count = self.truth.search.observed.unwrap_or(usize::MAX);
        for (k, s) in roots.into_iter().enumerate().take(count) {
            if s.re >= 0.0 {
                let (frequency_hz, growth_rate) = (s.im / TAU, s.re);
                return Err(BenchError::Unstable { point: point.id.clone(), frequency_hz, growth_rate });
            }
            let growth_rate = s.re + noise.growth_rate * normal(&mut stream);
            let frequency_hz = s.im / TAU + noise.frequency_hz * normal(&mut stream);
            let shape = chain.march(s).pressures;
            let pressures = (0..shape.len()).map(|m| {
                let error = C64::new(normal(&mut stream), normal(&mut stream)) * noise.pressure;
                let heard = m != reference && !microphones.dead.contains(&(m + 1));
                heard.then(|| shape[m] / shape[reference] + error)
            });
            let pressures = pressures.collect();
            let (point, feedback) = (point.id.clone(), chain.feedback(s));
            measured.push(Measured {
                point,
                mode: k + 1,
                exact: s,
                feedback,
                growth_rate,
                frequency_hz,
                pressures,
            });
        }
        let mut readings = Vec::new();
        if let Some(thermometers) = &self.truth.thermometers {
            for at in &thermometers.at {
                let excess = base.temperature(*at)[0] - ambient;
                let temperature = ambient + (1.0 - thermometers.radiation) * excess;
                let stated = thermometers.radiation_sd * excess;
                readings.push(BenchReading {
                    point: point.id.clone(),
                    at: *at,
                    temperature: temperature + thermometers.sd * normal(&mut stream),
                    sd: thermometers.sd.hypot(stated),
                });
            }
        }
        Ok((measured, readings))
    }
}

impl BenchObservations {
    /// Writes the files into `folder`, which is made if it is not there.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), BenchError> {
        let write = |name: &str, text: &str| {
            let path = folder.join(name);
            std::fs::write(&path, text).map_err(|cause| BenchError::Write { path, cause })
        };
        std::fs::create_dir_all(folder)
            .map_err(|cause| BenchError::Write { path: folder.to_owned(), cause })?;
        write("modes.csv", &self.modes_csv())?;
        write("observations.toml", &format!("kind = \"virtual\"\nsource = \"{}\"\n", self.source))?;
        if self.readings.is_empty() {
            return Ok(());
        }
        let mut text = String::from("point,at [m],temperature [K],sd [K]\n");
        for r in &self.readings {
            let _ = writeln!(text, "{},{},{:.2},{:.2}", r.point, r.at, r.temperature, r.sd);
        }
        write("readings.csv", &text)
    }

    fn modes_csv(&self) -> String {
        let count = self.modes.first().map_or(0, |mode| mode.pressures.len());
        // A microphone that is dead everywhere keeps its column; the reference has none.
        let heard: Vec<usize> = (0..count).filter(|m| *m != self.reference).collect();
        let mut text = String::from(
            "point,mode,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]",
        );
        for m in heard.iter().map(|m| m + 1) {
            let _ = write!(text, ",p{m}_re,p{m}_re_sd,p{m}_im,p{m}_im_sd");
        }
        text.push('\n');
        let [growth_sd, frequency_sd, pressure_sd] = self.sds;
        for mode in &self.modes {
            let Measured { point, mode: number, growth_rate, frequency_hz, .. } = mode;
            let _ = write!(
                text,
                "{point},{number},{growth_rate:.4},{growth_sd},{frequency_hz:.4},{frequency_sd}"
            );
            for p in heard.iter().map(|m| mode.pressures[*m]) {
                let _ = match p {
                    Some(p) => write!(text, ",{:.5},{pressure_sd},{:.5},{pressure_sd}", p.re, p.im),
                    None => write!(text, ",,,,"),
                };
            }
            text.push('\n');
        }
        text
    }
}
