//! Steady random noise: transfer functions between channels, and what follows from them. Must not know pings or clicks.

mod spectra;
mod switched;
mod transmission;

pub use spectra::{Spectra, TransferEstimate};
pub use switched::{GainPair, SwitchedGains};
pub use transmission::{TransmissionTube, Transmitted};
