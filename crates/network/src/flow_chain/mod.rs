//! Chains with mean flow: two acoustic waves and an entropy wave in every duct, Mach numbers below 0.3.
//!
//! In a duct of mean velocity U the disturbances obey s rho u + rho U u' + p' = -kappa_mu u and (s p + U
//! p')/(rho c^2) + u' = -kappa_ep p (primes: d/dx); what density has beyond p/c^2 is carried along with U.
//! Where ducts meet, the linearised balances of mass, momentum and energy hold, in two steps:
//!
//! 1. the area changes. An expansion keeps p A_2 + rho u^2 A over the step (the pressure on the face is the
//!    upstream one: Borda and Carnot); a contraction keeps p/rho^gamma, and so does a step of a smooth wall
//!    ([`FlowDuct::smooth`]);
//! 2. heat and devices act. Mean heat raises the temperature by a ratio and by itself does not fluctuate per
//!    volume; k_mu u and k_mp p are forces on the gas, k_eu u and k_ep p take heat of gamma p/(gamma-1) times
//!    themselves per area, a flame gives Q'/Q = F u'/U, and a side branch takes mass with the stagnation
//!    enthalpy and axial velocity of the stream. u and p are those upstream of the place, as in
//!    [`crate::Network`], to which the chain tends as the flow slows down.
//!
//! The gas of a duct is perfect with constant gamma. Where the next duct has another gamma, the gas changes
//! with the heat of step 2, and takes no heat if it changes at constant pressure and density. A steady flame
//! then leaves the volume flow as it is when the flow slows down, as a thin flame that moves and burns at its
//! own pace does; enthalpies c_p T from 0 K, as if the place of the change stood still and all the gas that
//! passes changed there without heat, would make u_2 = u_1 gamma_1 (gamma_2 - 1)/(gamma_2 (gamma_1 - 1)). A
//! flame that follows the flow (F = 1) has u_2'/U_2 = u_1'/U_1 either way.
//!
//! Entropy waves do not disperse, or are left out ([`FlowChain::without_entropy_waves`]).
//!
//! From the bottom: `ducts` and `slots` are what a caller says, `mean` and `gate` the balances where ducts
//! meet, `assembly` the chain; `passage` carries disturbances through it, and the rest asks. Knows of the
//! chain at rest what both share: slots, laws, answers.

mod adjoint;
mod along;
mod assembly;
mod attach;
mod budget;
mod chain;
mod ducts;
mod forced;
mod gate;
mod mean;
pub(crate) mod number;
mod passage;
mod reference_point;
mod response;
mod slots;
mod solve;

pub use assembly::FlowChain;
pub use ducts::{Action, ActionKind, FlowDuct, FlowEnd, FlowState, FlowWall, Reference};
