//! The slow one-dimensional conjugate heat-transfer flow of a heated vertical tube.
//!
//! What acoustics takes from here is a [`BaseState`] per operating point: temperature, sound speed and density
//! along the tube and the velocity at the heater, each with its uncertainty. Knows no acoustics beyond the time a
//! pulse takes along the tube.
//!
//! # Conventions
//!
//! * SI units; temperatures in kelvin; x runs upward from the bottom end of the tube.
//! * Mass flux and velocity are positive upward.
//! * An uncertainty is a list of independent error components, each given at one standard deviation.
//!
//! # Example
//!
//! ```
//! use rijke_flow::BaseState;
//! use rijke_rig::Gas;
//! // Without power the tube is at the ambient temperature, here known to 0.1 K.
//! let base = BaseState::uniform(&Gas::air(), 101_325.0, 1.0, 293.15, 0.1)?;
//! assert!((base.sound_speed(0.5) - 343.3).abs() < 0.1);
//! let elements = base.stretches(&[0.0, 0.25, 0.5, 0.75, 1.0]);
//! assert_eq!(elements.len(), 4);
//! # Ok::<(), rijke_flow::FlowError>(())
//! ```

mod base;
mod error;
mod infer;
mod number;
mod tube;

pub use base::profiles::{PROFILES, VELOCITIES, read_profiles};
pub use base::state::{BaseState, ErrorComponent, Stretch};
pub use base::states::BaseStates;
pub use error::FlowError;
pub use infer::{assimilate, settled};
pub use number::{Dual, Lanes, Number, Single};
pub use tube::closures::Closures;
pub use tube::draught::Draught;
pub use tube::march::March;
pub use tube::parameters::{Parameters, UNKNOWNS, Unknowns, unknowns};
pub use tube::pipe::Pipe;
pub use tube::steady::{SENSITIVE_TO, Sensitivity, Steady};
pub use tube::transient::{Implicit, Transient};
pub use tube::wall::Budget;
