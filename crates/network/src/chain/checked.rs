//! What laws must be for a network to have an answer.

use super::coefficients::{At, Coefficients, Laws};
use super::network::{AREA, Attachment, DENSITY, LENGTH, Network, SOUND_SPEED};
use crate::error::NetworkError;
use rijke_numerics::C64;

/// Exponent of a wave beyond which squares of it leave double precision.
const LARGEST: f64 = 340.0;

impl Network {
    /// Fails for a law that is attached and not there, and for a property that laws make negative or zero at
    /// `s`. Costs all laws at `s` where one acts on a property.
    pub(crate) fn check<K: Coefficients + ?Sized>(
        &self,
        k: &K,
        s: C64,
        laws: &mut Laws,
    ) -> Result<(), NetworkError> {
        self.check_numbers(k)?;
        if self.varied().next().is_none() {
            return Ok(());
        }
        let at = At::search(s);
        laws.reset(k.laws(), &at);
        k.fill(&at, laws);
        self.check_properties(laws)
    }

    /// Fails for a law that is attached and not there.
    pub(crate) fn check_numbers<K: Coefficients + ?Sized>(&self, k: &K) -> Result<(), NetworkError> {
        let laws = k.laws();
        if self.attachments.iter().all(|a| a.law < laws) {
            return Ok(());
        }
        let missing = self.attachments().find(|(_, law, _)| *law >= laws);
        missing.map_or(Ok(()), |(slot, law, _)| Err(NetworkError::NoLaw { slot, law, laws }))
    }

    /// Fails for a property of a segment that `laws` make negative, zero or infinite. One that is no number
    /// is left to the question itself.
    pub(crate) fn check_properties(&self, laws: &Laws) -> Result<(), NetworkError> {
        for a in self.varied() {
            let index = (a.key - 2) / 2;
            let value = self.property(index, a.kind, laws).value.re;
            if value <= 0.0 || value.is_infinite() {
                let quantity = match a.kind {
                    LENGTH => "length",
                    AREA => "area",
                    SOUND_SPEED => "sound speed",
                    _ => "density",
                };
                return Err(NetworkError::Property { index, quantity, value });
            }
        }
        Ok(())
    }

    /// What is attached to lengths, areas, speeds of sound and densities.
    fn varied(&self) -> impl Iterator<Item = &Attachment> {
        let end = 2 + 2 * self.segments.len();
        self.attachments
            .iter()
            .filter(move |a| a.key > 0 && a.key < end && a.key % 2 == 0 && a.kind <= DENSITY)
    }
}

/// An error at growth rates up to `sigma` in modulus, with its true reason where waves over a travel time of
/// `time` leave the range of a number.
pub(crate) fn beyond_range(error: NetworkError, sigma: f64, time: f64) -> NetworkError {
    let exponent = sigma.abs() * time;
    match error {
        NetworkError::NotFinite { .. } | NetworkError::Border { .. } if exponent > LARGEST => {
            NetworkError::Overflow { sigma, exponent, most: LARGEST / time }
        }
        other => other,
    }
}
