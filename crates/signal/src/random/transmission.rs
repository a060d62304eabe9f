//! Transmission through a specimen between microphones, from one record.

use super::pressures::RelativePressures;
use rijke_numerics::C64;
use std::f64::consts::TAU;

/// A tube with microphones before and behind a specimen, in gas at rest without loss.
#[derive(Clone, Debug, PartialEq)]
pub struct TransmissionTube {
    /// Places of the microphones, m.
    pub places: Vec<f64>,
    /// Where the specimen begins and ends, m.
    pub between: [f64; 2],
    /// Speed of sound, m/s.
    pub sound_speed: f64,
}

/// What a specimen does at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transmitted {
    /// Transmission coefficient of waves of pressure with an end that reflects nothing, of a specimen that is
    /// symmetric and reciprocal.
    pub coefficient: C64,
    /// Energy that leaves it downstream over energy that enters it upstream: 1 if it takes none.
    pub energy: f64,
    /// Waves that run downstream, behind it over before it, and waves that run upstream, before it over
    /// behind it, each with the phase of empty tube taken away: both 1 if there is nothing.
    pub through: [C64; 2],
}

/// Transmission at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransmissionLoss {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Transmission loss and its standard deviation, dB.
    pub loss_db: [f64; 2],
    /// What the specimen does.
    pub transmitted: Transmitted,
}

/// Medians within a band of 100 Hz.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LossBand {
    /// From and to, Hz.
    pub from_to_hz: [f64; 2],
    /// Transmission loss and its standard deviation, dB.
    pub loss_db: [f64; 2],
    /// As [`Transmitted::energy`].
    pub energy: f64,
    /// Moduli of [`Transmitted::through`].
    pub through: [f64; 2],
}

/// Width of a band, Hz.
const BAND: f64 = 100.0;

impl LossBand {
    /// The bands of losses at ascending frequencies.
    #[must_use]
    pub fn of(losses: &[TransmissionLoss]) -> Vec<Self> {
        let band = |l: &TransmissionLoss| (l.frequency_hz / BAND).floor();
        let one = |all: &[TransmissionLoss]| {
            let median = |of: &dyn Fn(&TransmissionLoss) -> f64| {
                let mut values: Vec<f64> = all.iter().map(of).collect();
                values.sort_by(f64::total_cmp);
                values[values.len() / 2]
            };
            let from = BAND * band(&all[0]);
            Self {
                from_to_hz: [from, from + BAND],
                loss_db: [0, 1].map(|k| median(&|l| l.loss_db[k])),
                energy: median(&|l| l.transmitted.energy),
                through: [0, 1].map(|k| median(&|l| l.transmitted.through[k].norm())),
            }
        };
        losses.chunk_by(|a, b| band(a) == band(b)).map(one).collect()
    }
}

impl TransmissionTube {
    /// How many microphones are before the specimen, and how many behind it; waves are told apart by two.
    #[must_use]
    pub fn sides(&self) -> [usize; 2] {
        let [from, to] = self.between;
        let count = |side: &dyn Fn(f64) -> bool| self.places.iter().filter(|x| side(**x)).count();
        [count(&|x| x <= from), count(&|x| x >= to)]
    }

    /// At every frequency at which the microphones can tell the waves apart, with errors of the places (m)
    /// and of the speed of sound (relative).
    #[must_use]
    pub fn losses(&self, heard: &RelativePressures, sds_of_places: [f64; 2]) -> Vec<TransmissionLoss> {
        let rows = heard.frequency_hz.iter().zip(&heard.pressures).zip(&heard.relative_sd);
        let one = |((f, p), sds): ((&f64, &Vec<C64>), &Vec<f64>)| {
            let transmitted = self.transmitted(*f, p)?;
            let loss_db = self.loss(*f, p, sds, sds_of_places).unwrap_or([f64::NAN; 2]);
            Some(TransmissionLoss { frequency_hz: *f, loss_db, transmitted })
        };
        rows.filter_map(one).collect()
    }

    /// From the pressures at the microphones; none if a side has less than two microphones, or those cannot
    /// tell the waves apart. The two waves of each side are fitted by least squares; Song & Bolton, J.
    /// Acoust. Soc. Am. 107 (2000) 1131.
    #[must_use]
    pub fn transmitted(&self, frequency_hz: f64, pressures: &[C64]) -> Option<Transmitted> {
        let k = TAU * frequency_hz / self.sound_speed;
        let [front, back] = self.between;
        // Waves as pressures at the two faces.
        let [a, b] = self.waves(k, front, pressures, |x| x <= front)?;
        let [c, d] = self.waves(k, back, pressures, |x| x >= back)?;
        let (p0, u0, p1, u1) = (a + b, a - b, c + d, c - d);
        let common = p0 * u1 + p1 * u0;
        let (same, up, down) = (p1 * u1 + p0 * u0, p0 * p0 - p1 * p1, u0 * u0 - u1 * u1);
        let phase = C64::from_polar(1.0, k * (back - front));
        Some(Transmitted {
            coefficient: 2.0 * common / (2.0 * same + up + down),
            energy: (c.norm_sqr() - d.norm_sqr()) / (a.norm_sqr() - b.norm_sqr()),
            through: [c * phase / a, b * phase / d],
        })
    }

    /// The waves that run downstream and upstream at `x`.
    fn waves(&self, k: f64, x: f64, pressures: &[C64], side: impl Fn(f64) -> bool) -> Option<[C64; 2]> {
        let (mut count, mut cross, mut right) = (0.0, C64::ZERO, [C64::ZERO; 2]);
        for (at, p) in self.places.iter().zip(pressures).filter(|(at, _)| side(**at)) {
            let down = C64::from_polar(1.0, -k * (at - x));
            count += 1.0;
            cross += down.conj() * down.conj();
            right[0] += down.conj() * p;
            right[1] += down * p;
        }
        let det = count * count - cross.norm_sqr();
        (det > 1e-6 * count * count).then(|| {
            [(count * right[0] - cross * right[1]) / det, (count * right[1] - cross.conj() * right[0]) / det]
        })
    }

    /// Transmission loss in dB, and its standard deviation from errors of the pressures (relative, of real
    /// and imaginary part), of the places (m) and of the speed of sound (relative).
    #[must_use]
    pub fn loss(
        &self,
        frequency_hz: f64,
        pressures: &[C64],
        sds: &[f64],
        [place_sd, sound_speed_sd]: [f64; 2],
    ) -> Option<[f64; 2]> {
        let loss = |tube: &Self, p: &[C64]| {
            tube.transmitted(frequency_hz, p).map(|t| -20.0 * t.coefficient.norm().log10())
        };
        let value = loss(self, pressures)?;
        let mut variance = 0.0;
        // By steps of one standard deviation to both sides, which also sees where it is no small one.
        let mut add = |up: Option<f64>, down: Option<f64>| {
            variance += (0.5 * (up.unwrap_or(value) - down.unwrap_or(value))).powi(2);
        };
        for m in 0..pressures.len() {
            for direction in [C64::ONE, C64::I] {
                let moved = |sign: f64| {
                    let mut p = pressures.to_vec();
                    p[m] *= 1.0 + sign * sds[m] * direction;
                    loss(self, &p)
                };
                add(moved(1.0), moved(-1.0));
            }
            let moved = |sign: f64| {
                let mut tube = self.clone();
                tube.places[m] += sign * place_sd;
                loss(&tube, pressures)
            };
            add(moved(1.0), moved(-1.0));
        }
        let moved = |sign: f64| {
            let tube = Self { sound_speed: self.sound_speed * (1.0 + sign * sound_speed_sd), ..self.clone() };
            loss(&tube, pressures)
        };
        add(moved(1.0), moved(-1.0));
        Some([value, variance.sqrt()])
    }
}
