//! One module per scientific question; each returns numbers that serialise, and never draws.
//!
//! # Conventions
//!
//! * SI units, angles in rad, s = sigma + i omega in 1/s and rad/s; ln of likelihoods in nats. "Per datapoint" is per
//!   operating point.
//! * Every record says in its [`Provenance`] whether its data were measured or virtual, and what was rejected.
//! * A [`Check`] is a statement of the paper's text or of an acceptance list, with the number that decides it.
//! * Standard deviations are called `sd`.

mod records;

pub use records::{
    Case, Check, Consistency, ConsistencyRow, CurvePoint, DataKind, EmptyTube, Evidence, MeasuredPoint,
    ParameterName, ParameterValue, ProngModel, Prongs, Provenance, RejectedRecord,
};
