//! Random noise, sweeps and periodic excitations: transfer functions between channels, and what follows from
//! them. Must not know pings or clicks.

mod compared;
mod doubts;
mod one_source;
mod pressures;
mod spectra;
mod swept;
mod switched;
mod transmission;

pub use compared::{ComparedChannels, ComparisonFault};
pub use doubts::{SwitchedDoubt, SwitchedFault};
pub use pressures::{ChannelGains, PressureFault, RelativePressures};
pub(crate) use spectra::live_length;
pub use spectra::{Spectra, TransferEstimate};
pub use swept::{Field, Swept, SweptOptions};
pub use switched::{GainPair, SwitchedGains};
pub use transmission::{LossBand, TransmissionLoss, TransmissionTube, Transmitted, TubeDuct, TubeErrors};
