//! The network: a chain of segments, the places between them, two ends, and the slots that laws attach to.

use crate::error::NetworkError;
use crate::slot::Slot;
use rijke_numerics::C64;

/// A straight piece of duct with uniform properties, a lossy transmission line:
/// dp/dx = -(s rho + viscous) u, du/dx = -(s/(rho c^2) + thermal) p.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Length, m.
    pub length: f64,
    /// Cross-section, m^2. Only ratios between neighbours matter.
    pub area: f64,
    /// Speed of sound, m/s.
    pub sound_speed: f64,
    /// Density, kg/m^3.
    pub density: f64,
}

impl Segment {
    /// A piece of `length` (m) and cross-section `area` (m^2) with the given speed of sound (m/s) and density
    /// (kg/m^3).
    #[must_use]
    pub fn new(length: f64, area: f64, sound_speed: f64, density: f64) -> Self {
        Self { length, area, sound_speed, density }
    }

    /// Characteristic impedance rho c, Pa s/m.
    #[must_use]
    pub fn impedance(&self) -> f64 {
        self.density * self.sound_speed
    }

    /// Two segments that stand for a duct along which gas or area vary, of which `halves` are the halves: of
    /// one area, each with the means of rho/A and A/(rho c^2) over it (per metre, of pressure and volume
    /// flow). What is kept is the means over the whole, and the first moments.
    ///
    /// With one mean a piece is of second order in its length h: what is left out is the commutator of its
    /// ends (the second term of Magnus), that is the first moments. Two halves that differ by D have a moment
    /// of D h^2/8, a linear profile whose halves differ by D one of D h^2/6: hence 4/3 of the difference, and
    /// fourth order. Both properties stay positive where the halves differ by less than a factor of seven.
    #[must_use]
    pub fn with_first_moment(halves: [Self; 2]) -> [Self; 2] {
        let compliance = |s: &Self| (s.density * s.sound_speed.powi(2)).recip();
        let apart = |value: fn(&Self) -> f64| {
            let [first, second] = [&halves[0], &halves[1]].map(value);
            let (mean, difference) = (0.5 * (first + second), 2.0 / 3.0 * (second - first));
            [mean - difference, mean + difference]
        };
        let (densities, compliances) = (apart(|s| s.density), apart(compliance));
        std::array::from_fn(|k| Self {
            density: densities[k],
            sound_speed: (densities[k] * compliances[k]).sqrt().recip(),
            ..halves[k]
        })
    }
}

/// Feedback at one place, in the order k_mu, k_mp, k_eu, k_ep.
pub(crate) type Feedback = [C64; 4];

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Attachment {
    /// Order in which a downstream sweep meets it: 0 the upstream end, then 1 + 2j place j, 2 + 2j segment j,
    /// ...
    pub(crate) key: usize,
    /// Which of the quantities at this key.
    pub(crate) kind: usize,
    pub(crate) law: usize,
    pub(crate) weight: f64,
}

/// A chain of segments with feedback at the places between them and a reflection at either end.
///
/// ```
/// use rijke_network::{Constant, Network, Newton, Segment, Slot, Workspace};
/// use rijke_numerics::C64;
/// let mut tube = Network::new(vec![Segment::new(1.0, 1.8e-3, 343.2, 1.2041)]).unwrap();
/// tube.set(Slot::Upstream, C64::new(-0.95, 0.0)).unwrap();
/// tube.set(Slot::Downstream, C64::new(-0.95, 0.0)).unwrap();
/// let root = tube.solve(&Constant, C64::new(0.0, 1100.0), &Newton::default(), &mut Workspace::default()).unwrap();
/// assert!((root.s - C64::new(343.2 * 0.95f64.ln(), 343.2 * std::f64::consts::PI)).norm() < 1e-9);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Network {
    pub(crate) segments: Vec<Segment>,
    /// Constant feedback at each place; N + 1 of them.
    pub(crate) feedback: Vec<Feedback>,
    /// Constant loss per metre of each segment: viscous, thermal.
    pub(crate) losses: Vec<[C64; 2]>,
    /// Constant reflection coefficients, upstream and downstream.
    pub(crate) ends: [C64; 2],
    /// Sorted by key.
    pub(crate) attachments: Vec<Attachment>,
}

impl Network {
    /// A chain without feedback or losses and with ends that do not reflect.
    ///
    /// # Errors
    /// [`NetworkError::Empty`], or [`NetworkError::Segment`] unless all properties are positive and finite.
    pub fn new(segments: Vec<Segment>) -> Result<Self, NetworkError> {
        if segments.is_empty() {
            return Err(NetworkError::Empty);
        }
        for (index, s) in segments.iter().enumerate() {
            let named = [
                ("length", s.length),
                ("area", s.area),
                ("sound speed", s.sound_speed),
                ("density", s.density),
            ];
            if let Some(&(quantity, value)) = named.iter().find(|(_, v)| !(v.is_finite() && *v > 0.0)) {
                return Err(NetworkError::Segment { index, quantity, value });
            }
        }
        let n = segments.len();
        Ok(Self {
            segments,
            feedback: vec![[C64::ZERO; 4]; n + 1],
            losses: vec![[C64::ZERO; 2]; n],
            ends: [C64::ZERO; 2],
            attachments: Vec::new(),
        })
    }

    /// A uniform tube of the properties of `whole`, cut at every position of `cuts` (m from the upstream end,
    /// any order, repeated or end positions ignored). [`Network::place_at`] finds the places again.
    ///
    /// # Errors
    /// As [`Network::new`], or [`NetworkError::Outside`] for a cut beyond the tube.
    pub fn cut_tube(whole: Segment, cuts: &[f64]) -> Result<Self, NetworkError> {
        Self::new(vec![whole])?;
        let mut at = vec![0.0, whole.length];
        for &x in cuts {
            if !(0.0..=whole.length).contains(&x) {
                return Err(NetworkError::Outside { x, length: whole.length });
            }
            at.push(x);
        }
        at.sort_by(f64::total_cmp);
        at.dedup_by(|a, b| (*a - *b).abs() <= SAME_PLACE * whole.length);
        Self::new(at.windows(2).map(|w| Segment { length: w[1] - w[0], ..whole }).collect())
    }

    /// The segments, from upstream to downstream.
    #[must_use]
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Total length, m.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.segments.iter().map(|s| s.length).sum()
    }

    /// Time that sound needs from end to end, s. Modes lie about pi over this apart in angular frequency.
    #[must_use]
    pub fn travel_time(&self) -> f64 {
        self.segments.iter().map(|s| s.length / s.sound_speed).sum()
    }

    /// Position of place `j`, m from the upstream end.
    #[must_use]
    pub fn position(&self, place: usize) -> f64 {
        self.segments.iter().take(place).map(|s| s.length).sum()
    }

    /// The place at position `x` (m from the upstream end), to 1e-9 of the length.
    ///
    /// # Errors
    /// [`NetworkError::NoPlace`] if no segment ends there: cut the chain there first.
    pub fn place_at(&self, x: f64) -> Result<usize, NetworkError> {
        let length = self.length();
        let mut position = 0.0;
        for place in 0..=self.segments.len() {
            if (position - x).abs() <= SAME_PLACE * length {
                return Ok(place);
            }
            position += self.segments.get(place).map_or(0.0, |s| s.length);
        }
        Err(NetworkError::NoPlace { x, length })
    }

    /// Gives a slot its constant value; what is attached adds to it.
    ///
    /// # Errors
    /// [`NetworkError::Slot`] if there is no such segment or place; [`NetworkError::Segment`] if a property
    /// of a segment is not a positive real number.
    pub fn set(&mut self, slot: Slot, value: C64) -> Result<(), NetworkError> {
        let (key, kind) = self.locate(slot)?;
        let index = key.saturating_sub(1) / 2;
        match slot {
            Slot::Length(_) | Slot::Area(_) | Slot::SoundSpeed(_) | Slot::Density(_) => {
                const NAMES: [&str; 4] = ["length", "area", "sound speed", "density"];
                if !(value.re.is_finite() && value.re > 0.0 && value.im == 0.0) {
                    return Err(NetworkError::Segment { index, quantity: NAMES[kind], value: value.re });
                }
                let segment = &mut self.segments[index];
                match kind {
                    LENGTH => segment.length = value.re,
                    AREA => segment.area = value.re,
                    SOUND_SPEED => segment.sound_speed = value.re,
                    _ => segment.density = value.re,
                }
            }
            Slot::Viscous(i) | Slot::Thermal(i) => self.losses[i][kind - VISCOUS] = value,
            Slot::Mu(j) | Slot::Mp(j) | Slot::Eu(j) | Slot::Ep(j) => self.feedback[j][kind] = value,
            Slot::Upstream => self.ends[0] = value,
            Slot::Downstream => self.ends[1] = value,
        }
        Ok(())
    }

    /// Adds `weight` times law number `law` to a slot. Whether there is such a law is known with the first
    /// question, which fails with [`NetworkError::NoLaw`] if there is none.
    ///
    /// # Errors
    /// [`NetworkError::Slot`] if there is no such segment or place.
    pub fn attach(&mut self, slot: Slot, law: usize, weight: f64) -> Result<(), NetworkError> {
        let (key, kind) = self.locate(slot)?;
        let at = self.attachments.partition_point(|a| a.key <= key);
        self.attachments.insert(at, Attachment { key, kind, law, weight });
        Ok(())
    }

    /// Everything attached: slot, law, weight.
    pub fn attachments(&self) -> impl Iterator<Item = (Slot, usize, f64)> {
        let end = 2 + 2 * self.segments.len();
        self.attachments.iter().map(move |a| {
            let (i, place) = (a.key.saturating_sub(2) / 2, a.key.saturating_sub(1) / 2);
            let slot = match (a.key, a.kind) {
                (0, _) => Slot::Upstream,
                (key, _) if key == end => Slot::Downstream,
                (key, 0) if key % 2 == 1 => Slot::Mu(place),
                (key, 1) if key % 2 == 1 => Slot::Mp(place),
                (key, 2) if key % 2 == 1 => Slot::Eu(place),
                (key, _) if key % 2 == 1 => Slot::Ep(place),
                (_, LENGTH) => Slot::Length(i),
                (_, AREA) => Slot::Area(i),
                (_, SOUND_SPEED) => Slot::SoundSpeed(i),
                (_, DENSITY) => Slot::Density(i),
                (_, VISCOUS) => Slot::Viscous(i),
                _ => Slot::Thermal(i),
            };
            (slot, a.law, a.weight)
        })
    }

    fn locate(&self, slot: Slot) -> Result<(usize, usize), NetworkError> {
        let n = self.segments.len();
        let wrong = NetworkError::Slot { slot, segments: n };
        // Before a number is doubled that could leave its range.
        if slot.index().is_some_and(|index| index > n) {
            return Err(wrong);
        }
        let (key, kind) = match slot {
            Slot::Upstream => (0, 0),
            Slot::Mu(j) => (1 + 2 * j, 0),
            Slot::Mp(j) => (1 + 2 * j, 1),
            Slot::Eu(j) => (1 + 2 * j, 2),
            Slot::Ep(j) => (1 + 2 * j, 3),
            Slot::Length(i) => (2 + 2 * i, LENGTH),
            Slot::Area(i) => (2 + 2 * i, AREA),
            Slot::SoundSpeed(i) => (2 + 2 * i, SOUND_SPEED),
            Slot::Density(i) => (2 + 2 * i, DENSITY),
            Slot::Viscous(i) => (2 + 2 * i, VISCOUS),
            Slot::Thermal(i) => (2 + 2 * i, THERMAL),
            Slot::Downstream => (2 + 2 * n, 0),
        };
        let last = if slot == Slot::Downstream { 2 + 2 * n } else { 1 + 2 * n };
        if key <= last { Ok((key, kind)) } else { Err(wrong) }
    }
}

/// Places closer than this part of the length are the same.
const SAME_PLACE: f64 = 1e-9;

pub(crate) const LENGTH: usize = 0;
pub(crate) const AREA: usize = 1;
pub(crate) const SOUND_SPEED: usize = 2;
pub(crate) const DENSITY: usize = 3;
pub(crate) const VISCOUS: usize = 4;
pub(crate) const THERMAL: usize = 5;
