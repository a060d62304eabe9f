#![doc = include_str!("../README.md")]

pub use rijke_draw as draw;
pub use rijke_engine as engine;
pub use rijke_flow as flow;
pub use rijke_formula as formula;
pub use rijke_inference as inference;
pub use rijke_intake as intake;
pub use rijke_lab as lab;
pub use rijke_network as network;
pub use rijke_numerics as numerics;
pub use rijke_report as report;
pub use rijke_rig as rig;
pub use rijke_signal as signal;
pub use rijke_study as study;

/// What most programs name: `use rijke::prelude::*;`.
pub mod prelude {
    pub use rijke_engine::run::{Run, StageRecord, Trusted};
    pub use rijke_inference::{
        Data, Forward, MapOptions, NoiseGroup, Observation, Parameter, Parameters, Posterior, Prior,
    };
    pub use rijke_network::file::{Built, NamedNumbers};
    pub use rijke_network::{Coefficients, Mode, Network, Region, Response, Workspace};
    pub use rijke_numerics::{C64, Jet, JetSpace, Order};
    pub use rijke_report::StudyPage;
    pub use rijke_signal::{PingOptions, Trace, fit_ping};
    pub use rijke_study::Study;
}
