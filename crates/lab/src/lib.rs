//! The virtual laboratory: a thermoacoustic rig that exists only as a computation, and the acquisition system that
//! records it. It stands in for measurements that are not public.
//!
//! Its physics is finer than that of any candidate model, solves the distributed problem its own way, and shares no
//! acoustic code with the network model: a model that is tested on data made by itself proves nothing. Its truth is one
//! file, `fixtures/lab/truth.toml`, each value with a source; the records carry none of it.
//!
//! * [`duct`]: the lossy line with continuous c(x), integrated from mouth to mouth; [`walls`], [`radiation`].
//! * [`bench`](mod@bench): any chain of ducts, heat sources, obstacles and dampers, told by a truth file, observed with noise.
//! * [`VirtualRig`]: records as the acquisition system writes them, one at a time; a [`rijke_rig::RecordSource`].
//!
//! Knows no network, no candidate, no inference.
//!
//! # Conventions
//!
//! * SI units; x = 0 is the bottom mouth; time dependence e^{st}; volume velocity U positive upward.
//! * Everything is analytic in s: sqrt(s rho mu), ka = s a/(i c).
//! * A record depends on seed, truth and its own name alone: the same for any number of threads and any choice of rows.
//!
//! # Example
//!
//! ```
//! use rijke_lab::{Truth, VirtualRig};
//! use rijke_rig::{Campaign, RecordSource, Rig};
//! let (rig, campaign) = (Rig::juniper_yoko_2022(), Campaign::juniper_yoko_2022());
//! let lab = VirtualRig::new(&rig, &campaign, &Truth::standard(), &["C3".into()], Some(2), 1)?;
//! let ping = lab.ping(0, 1)?;
//! assert_eq!((ping.channels.len(), ping.len()), (8, 15_000));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod acoustics;
mod apparatus;
pub mod bench;
mod records;
mod truth;

pub use acoustics::{duct, obstacle, radiation, walls};
pub use apparatus::base::base_state;
pub use apparatus::mouths::mouths;
pub use records::faults::Fault;
pub use records::source::seed_of;
pub use records::virtual_rig::VirtualRig;
pub use truth::{
    Ambient, Channels, Ends, Faults, Flow, HeaterTruth, LabError, Loudspeaker, Noise, ProngSurface, Recorder,
    Thermocouples, Truth, Wall,
};
