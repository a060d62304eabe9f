//! Numbers that can be so, and that are most often a slip of the unit: one list for network files, rigs and
//! studies.

use std::f64::consts::PI;

/// Pressures of rigs, Pa.
pub const PRESSURE: [f64; 2] = [5e3, 1e8];
/// Prandtl numbers of gases.
pub const PRANDTL: [f64; 2] = [0.1, 1.5];
/// Viscosities of gases at 20 degrees Celsius, Pa s.
pub const VISCOSITY: [f64; 2] = [5e-6, 5e-5];

/// Gains of a flame over its mean, which is about 1: outside they are most often in another unit, such as per
/// cent.
pub const FLAME_GAINS: [f64; 2] = [0.01, 10.0];

/// Ducts colder than this, K, most often are so warm in degrees Celsius.
pub const COLD: f64 = 200.0;
/// Gas constants from this on, J/(kg K), are those of helium and hydrogen, which stay gases where it is
/// colder, and of liquids that are given as a gas.
const LIGHT: f64 = 1000.0;
/// As long as this, m, ducts are of most rigs, whatever the frequency.
const LONG: f64 = 100.0;
/// Wider ducts than this, m, are no slip where the sound is in plane waves.
const WIDE: f64 = 5.0;
/// A delay that is most often one in milliseconds, s.
const LATE: f64 = 1.0;
/// A duct of fewer wavelengths at the highest frequency is no slip, nor is a delay of fewer periods. Whoever
/// looks for the first mode of a tube, at a quarter of a wavelength, and gives its length in mm, gives 250.
const MOST_WAVELENGTHS: f64 = 200.0;
/// k a at which the first higher mode of a round duct is cut on: the first zero of J1'.
const CUT_ON: f64 = 1.841_183_78;

/// Whether a gas of this constant, J/(kg K), is a light one, or a liquid: of its temperature, viscosity and
/// Prandtl number nothing is known.
#[must_use]
pub fn is_light(gas_constant: f64) -> bool {
    gas_constant >= LIGHT
}

/// Whether a duct is too long, m, for the wavelength at the highest frequency, m.
#[must_use]
pub fn is_too_long(length: f64, wavelength: f64) -> bool {
    length > LONG.max(MOST_WAVELENGTHS * wavelength)
}

/// Whether a duct is too wide, m, for the wavelength at the highest frequency, m.
#[must_use]
pub fn is_too_wide(width: f64, wavelength: f64) -> bool {
    width > WIDE.max(wavelength)
}

/// Whether a delay, s, is too late for the highest frequency, Hz.
#[must_use]
pub fn is_too_late(delay: f64, highest_hz: f64) -> bool {
    delay.abs() > LATE && delay.abs() * highest_hz > MOST_WAVELENGTHS
}

/// The frequency from which on a higher mode is cut on in a round duct of this width (m), where sound travels
/// at `sound_speed` (m/s), Hz: above, the sound is not in plane waves alone.
#[must_use]
pub fn cut_on(width: f64, sound_speed: f64) -> f64 {
    CUT_ON * sound_speed / (PI * width)
}
