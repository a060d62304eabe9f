//! Microphones that recorded nothing: their numbers are none (NaN), and the others keep their names.

use super::channels::ChannelErrors;
use super::observation::{Click, Observations, Ping};
use super::rows::ModeRows;
use rijke_numerics::{C64, Matrix};

impl Ping {
    /// The same ping among `count` microphones, of which it knows those of the ascending numbers `known`; the
    /// others have no number.
    #[must_use]
    pub fn among(&self, known: &[usize], count: usize) -> Self {
        let mut pressures = vec![C64::new(f64::NAN, f64::NAN); count];
        for (m, p) in known.iter().zip(&self.pressures) {
            pressures[*m] = *p;
        }
        let reference = known[self.reference];
        let others = known.iter().filter(|m| **m != reference);
        let place = |m: &usize| ModeRows::pressure(m - usize::from(*m > reference));
        let places: Vec<usize> =
            [0, 1].into_iter().chain(others.flat_map(|m| [place(m), place(m) + 1])).collect();
        let covariance = spread(&self.covariance, &places, 2 * count, f64::NAN);
        Self { s: self.s, pressures, reference, covariance }
    }

    /// The same ping without all microphones but those of the ascending numbers `kept`, of which the
    /// reference is one.
    #[must_use]
    pub fn only(&self, kept: &[usize]) -> Self {
        let place = |m: &usize| ModeRows::pressure(m - usize::from(*m > self.reference));
        let others = kept.iter().filter(|m| **m != self.reference);
        let places: Vec<usize> =
            [0, 1].into_iter().chain(others.flat_map(|m| [place(m), place(m) + 1])).collect();
        Self {
            s: self.s,
            pressures: kept.iter().map(|m| self.pressures[*m]).collect(),
            reference: kept.iter().position(|m| *m == self.reference).unwrap_or(0),
            covariance: self.covariance.select(&places),
        }
    }
}

impl Click {
    /// As [`Ping::among`].
    #[must_use]
    pub fn among(&self, known: &[usize], count: usize) -> Self {
        let mut arrival_times = vec![f64::NAN; count];
        for (m, t) in known.iter().zip(&self.arrival_times) {
            arrival_times[*m] = *t;
        }
        Self { arrival_times, covariance: spread(&self.covariance, known, count, f64::NAN) }
    }
}

impl ChannelErrors {
    /// As [`Ping::among`]: channels of which no record tells have the largest variance of the others, and
    /// share nothing with them.
    #[must_use]
    pub fn among(&self, known: &[usize], count: usize, reference: usize) -> Self {
        let place = |m: &usize| m - usize::from(*m > reference);
        let places: Vec<usize> = known.iter().filter(|m| **m != reference).map(place).collect();
        let others = |matrix: &Matrix| {
            let largest = (0..matrix.rows()).map(|i| matrix[(i, i)]).fold(f64::MIN_POSITIVE, f64::max);
            let mut all = spread(matrix, &places, count - 1, 0.0);
            for i in (0..count - 1).filter(|i| !places.contains(i)) {
                all[(i, i)] = largest;
            }
            all
        };
        Self { delays: others(&self.delays), gains: others(&self.gains), contained: self.contained }
    }
}

impl Observations {
    /// The same with microphones that were dead in all records put back into the rig: `removed` has their
    /// numbers, ascending, and places. So the numbers of microphones are those of the rig everywhere.
    #[must_use]
    pub fn with_the_dead(mut self, removed: &[(usize, f64)]) -> Self {
        let count = self.rig.microphones.positions.len() + removed.len();
        let known: Vec<usize> = (0..count).filter(|m| removed.iter().all(|(r, _)| r != m)).collect();
        let microphones = &mut self.rig.microphones;
        removed.iter().for_each(|(m, x)| microphones.positions.insert(*m, *x));
        microphones.reference = known[microphones.reference];
        let reference = microphones.reference;
        for point in &mut self.points {
            let pings = point.ping.iter_mut().chain(point.pings.iter_mut().map(|p| &mut p.1));
            pings.for_each(|ping| *ping = ping.among(&known, count));
            let clicks = point.click.iter_mut().chain(point.clicks.iter_mut().map(|c| &mut c.1));
            clicks.for_each(|click| *click = click.among(&known, count));
        }
        self.channels = self.channels.map(|c| c.among(&known, count, reference));
        self
    }

    /// Leaves out the microphones of which nothing has a number.
    pub(crate) fn leave_out_the_dead(&mut self) {
        let count = self.rig.microphones.positions.len();
        let pings = || self.points.iter().flat_map(|p| p.ping.iter().chain(p.pings.iter().map(|p| &p.1)));
        let clicks = || self.points.iter().flat_map(|p| p.click.iter().chain(p.clicks.iter().map(|c| &c.1)));
        let reference = self.rig.microphones.reference;
        let heard = |m: &usize| {
            *m == reference
                || pings().any(|p| !p.pressures[*m].re.is_nan())
                || clicks().any(|c| !c.arrival_times[*m].is_nan())
        };
        if pings().next().is_none() && clicks().next().is_none() {
            return;
        }
        let kept: Vec<usize> = (0..count).filter(heard).collect();
        if kept.len() == count {
            return;
        }
        for point in &mut self.points {
            let pings = point.ping.iter_mut().chain(point.pings.iter_mut().map(|p| &mut p.1));
            pings.for_each(|ping| *ping = ping.only(&kept));
            for click in point.click.iter_mut().chain(point.clicks.iter_mut().map(|c| &mut c.1)) {
                let arrival_times = kept.iter().map(|m| click.arrival_times[*m]).collect();
                *click = Click { arrival_times, covariance: click.covariance.select(&kept) };
            }
        }
        if let Some(channels) = &mut self.channels {
            let others = kept.iter().filter(|m| **m != reference);
            let others: Vec<usize> = others.map(|m| m - usize::from(*m > reference)).collect();
            *channels = ChannelErrors {
                delays: channels.delays.select(&others),
                gains: channels.gains.select(&others),
                contained: channels.contained,
            };
        }
        let microphones = &mut self.rig.microphones;
        microphones.positions = kept.iter().map(|m| microphones.positions[*m]).collect();
        microphones.reference = kept.iter().position(|m| *m == reference).unwrap_or(0);
    }
}

/// A matrix among more rows and columns: its own stand at `places`, the others hold `rest`.
fn spread(matrix: &Matrix, places: &[usize], size: usize, rest: f64) -> Matrix {
    let own = |i: usize| places.iter().position(|p| *p == i);
    Matrix::from_fn(size, size, |i, j| match (own(i), own(j)) {
        (Some(a), Some(b)) => matrix[(a, b)],
        _ => rest,
    })
}
