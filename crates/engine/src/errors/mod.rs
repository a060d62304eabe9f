//! Errors that are not of one number alone: of base states, of channels, of laws, and what differs between
//! installations. What many data share is inferred with the model; the rest is covariance. Must not know
//! which candidates compete.

mod assemblies;
mod bends;
mod carried;
mod channels;
mod common;
mod law;
mod point_errors;
mod principal;
mod varying;

pub(crate) use assemblies::{Assemblies, Learned, OF_INSTALLATION};
pub(crate) use bends::Bends;
pub(crate) use carried::Carried;
pub(crate) use channels::{ChannelsOfModes, ThroughChannels};
pub(crate) use common::Common;
pub(crate) use law::LawErrors;
pub(crate) use point_errors::{
    Changes, PointErrors, changes, changes_by_factors, changes_by_factors_of, of_drift,
};
pub(crate) use varying::{Scatter, any_varies};
