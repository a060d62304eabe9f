//! Transmission through a specimen between microphones, from one record.

use super::pressures::RelativePressures;
use crate::campaign::kirchhoff;
use rijke_numerics::C64;
use rijke_rig::{GasState, Specimen};
use std::f64::consts::{PI, TAU};

/// A tube with microphones before and behind a specimen, in gas at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct TransmissionTube {
    /// Places of the microphones, m.
    pub places: Vec<f64>,
    /// Where the specimen begins and ends, m; the same place for one that is thin.
    pub between: [f64; 2],
    /// Speed of sound, m/s.
    pub sound_speed: f64,
    /// What thin boundary layers do to a wave before and behind the specimen, s^{1/2}/m: along 1 m its
    /// spectrum is multiplied with e^{-(1+i) layers sqrt(omega)}. In a round tube Kirchhoff's dispersion
    /// over its radius.
    pub layers: [f64; 2],
    /// By how much these are larger than those of a smooth wall; 0 for a tube without loss.
    pub wall_factor: f64,
}

/// Standard deviations of what a [`TransmissionTube`] is taken to be.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TubeErrors {
    /// Of the place of every microphone, m.
    pub place: f64,
    /// Of the speed of sound, relative.
    pub sound_speed: f64,
    /// Of the factor of the wall.
    pub wall_factor: f64,
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
    /// behind it, each with what the empty tube does taken away: both 1 if there is nothing.
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

impl TubeErrors {
    /// As the manifest states them.
    #[must_use]
    pub fn of(specimen: &Specimen) -> Self {
        Self {
            place: specimen.place_sd,
            sound_speed: specimen.sound_speed_sd,
            wall_factor: specimen.wall_factor_sd,
        }
    }
}

/// A duct along which waves run to a specimen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TubeDuct {
    /// Where it begins and ends, m.
    pub span: [f64; 2],
    /// Area at its ends, m^2.
    pub area: [f64; 2],
}

impl TransmissionTube {
    /// Of a specimen in a chain of ducts, with microphones at `places` (m): the walls are those of the last
    /// duct that begins before it, and of the first that ends behind it.
    #[must_use]
    pub fn of(specimen: &Specimen, places: Vec<f64>, ducts: &[TubeDuct], gas: &GasState) -> Self {
        let [front, back] = specimen.between;
        let before = ducts.iter().rfind(|d| d.span[0] < front).map(|d| d.area[1]);
        let behind = ducts.iter().find(|d| d.span[1] > back).map(|d| d.area[0]);
        let layer = |area: f64| kirchhoff(gas) / (area / PI).sqrt();
        Self {
            places,
            between: specimen.between,
            sound_speed: gas.sound_speed,
            layers: [before, behind].map(|area| area.map_or(0.0, layer)),
            wall_factor: specimen.wall_factor,
        }
    }

    /// How many microphones are before the specimen, and how many behind it; waves are told apart by two.
    #[must_use]
    pub fn sides(&self) -> [usize; 2] {
        let [from, to] = self.between;
        let count = |side: &dyn Fn(f64) -> bool| self.places.iter().filter(|x| side(**x)).count();
        [count(&|x| x <= from), count(&|x| x >= to)]
    }

    /// At every frequency at which the microphones can tell the waves apart.
    #[must_use]
    pub fn losses(&self, heard: &RelativePressures, errors: &TubeErrors) -> Vec<TransmissionLoss> {
        let rows = heard.frequency_hz.iter().zip(&heard.pressures).zip(&heard.relative_sd);
        let one = |((f, p), sds): ((&f64, &Vec<C64>), &Vec<f64>)| {
            let transmitted = self.transmitted(*f, p)?;
            let loss_db = self.loss(*f, p, sds, errors).unwrap_or([f64::NAN; 2]);
            Some(TransmissionLoss { frequency_hz: *f, loss_db, transmitted })
        };
        rows.filter_map(one).collect()
    }

    /// What 1 m before (0) and behind (1) the specimen does to the logarithm of a wave.
    fn decay(&self, side: usize, frequency_hz: f64) -> C64 {
        let omega = TAU * frequency_hz;
        let layers = self.wall_factor * self.layers[side] * omega.sqrt();
        C64::new(layers, omega / self.sound_speed + layers)
    }

    /// From the pressures at the microphones; none if a side has less than two microphones, or those cannot
    /// tell the waves apart. The two waves of each side are fitted by least squares and carried to the faces
    /// with the loss of the wall, which so is none of the specimen; Song & Bolton, J. Acoust. Soc. Am. 107
    /// (2000) 1131, with a complex wavenumber.
    #[must_use]
    pub fn transmitted(&self, frequency_hz: f64, pressures: &[C64]) -> Option<Transmitted> {
        let [before, behind] = [0, 1].map(|side| self.decay(side, frequency_hz));
        let [front, back] = self.between;
        // Waves as pressures at the two faces.
        let [a, b] = self.waves(before, front, pressures, |x| x <= front)?;
        let [c, d] = self.waves(behind, back, pressures, |x| x >= back)?;
        let (p0, u0, p1, u1) = (a + b, a - b, c + d, c - d);
        let common = p0 * u1 + p1 * u0;
        let (same, up, down) = (p1 * u1 + p0 * u0, p0 * p0 - p1 * p1, u0 * u0 - u1 * u1);
        let empty = (0.5 * (before + behind) * (back - front)).exp();
        Some(Transmitted {
            coefficient: 2.0 * common / (2.0 * same + up + down),
            energy: (c.norm_sqr() - d.norm_sqr()) / (a.norm_sqr() - b.norm_sqr()),
            through: [c * empty / a, b * empty / d],
        })
    }

    /// The waves that run downstream and upstream at `x`, of which 1 m changes the logarithm by `decay`.
    fn waves(&self, decay: C64, x: f64, pressures: &[C64], side: impl Fn(f64) -> bool) -> Option<[C64; 2]> {
        let (mut size, mut cross, mut right) = ([0.0; 2], C64::ZERO, [C64::ZERO; 2]);
        for (at, p) in self.places.iter().zip(pressures).filter(|(at, _)| side(**at)) {
            let down = (-decay * (at - x)).exp();
            let up = down.inv();
            size = [size[0] + down.norm_sqr(), size[1] + up.norm_sqr()];
            cross += down.conj() * up;
            right = [right[0] + down.conj() * p, right[1] + up.conj() * p];
        }
        let det = size[0] * size[1] - cross.norm_sqr();
        (det > 1e-6 * size[0] * size[1]).then(|| {
            [
                (size[1] * right[0] - cross * right[1]) / det,
                (size[0] * right[1] - cross.conj() * right[0]) / det,
            ]
        })
    }

    /// Transmission loss in dB, and its standard deviation from errors of the pressures (relative, of real
    /// and imaginary part) and of the tube.
    #[must_use]
    pub fn loss(
        &self,
        frequency_hz: f64,
        pressures: &[C64],
        sds: &[f64],
        errors: &TubeErrors,
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
                tube.places[m] += sign * errors.place;
                loss(&tube, pressures)
            };
            add(moved(1.0), moved(-1.0));
        }
        let moved = |sign: f64| {
            let sound_speed = self.sound_speed * (1.0 + sign * errors.sound_speed);
            loss(&Self { sound_speed, ..self.clone() }, pressures)
        };
        add(moved(1.0), moved(-1.0));
        let moved = |sign: f64| {
            let wall_factor = self.wall_factor + sign * errors.wall_factor;
            loss(&Self { wall_factor, ..self.clone() }, pressures)
        };
        add(moved(1.0), moved(-1.0));
        Some([value, variance.sqrt()])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rijke_rig::Gas;

    #[test]
    fn exact_the_walls_are_those_of_the_ducts_beside_the_specimen() {
        let specimen = Specimen {
            points: Vec::new(),
            between: [1.0, 1.02],
            place_sd: 1e-3,
            sound_speed_sd: 2e-3,
            wall_factor: 1.2,
            wall_factor_sd: 0.1,
        };
        let duct = |from: f64, to: f64, radius: f64| {
            let area = PI * radius * radius;
            TubeDuct { span: [from, to], area: [area; 2] }
        };
        let ducts = [duct(0.0, 1.0, 0.03), duct(1.0, 1.02, 0.01), duct(1.02, 2.0, 0.015)];
        let gas = Gas::air().at(293.15, 101_325.0);
        let tube = TransmissionTube::of(&specimen, vec![0.5, 1.5], &ducts, &gas);
        assert!((tube.layers[1] / tube.layers[0] - 2.0).abs() < 1e-12, "{:?}", tube.layers);
        assert!((tube.layers[0] * 0.03 / kirchhoff(&gas) - 1.0).abs() < 1e-12);
        assert_eq!((tube.sound_speed, tube.wall_factor), (gas.sound_speed, 1.2));
        assert_eq!(TubeErrors::of(&specimen).sound_speed, 2e-3);
    }
}
