//! What can go wrong.

use crate::slot::Slot;
use rijke_numerics::C64;
use std::f64::consts::TAU;

/// Why a network has no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NetworkError {
    /// There is no segment.
    #[error("the network has no segment: give at least one")]
    Empty,
    /// A property of a segment is not a positive finite number.
    #[error("segment {index}: the {quantity} is {value}, but must be positive and finite")]
    Segment {
        /// Number of the segment, from 0.
        index: usize,
        /// Which property.
        quantity: &'static str,
        /// Its value.
        value: f64,
    },
    /// Laws make a property of a segment that is not positive.
    #[error(
        "segment {index}: with what laws add to it the {quantity} is {value}, but must be positive: bound the parameters of these laws"
    )]
    Property {
        /// Number of the segment, from 0.
        index: usize,
        /// Which property.
        quantity: &'static str,
        /// Its value, or the real part of it.
        value: f64,
    },
    /// A law is attached that the coefficients do not have.
    #[error(
        "law {law} is attached to {slot:?}, but the coefficients have {laws} laws, numbered from 0: attach one of these"
    )]
    NoLaw {
        /// Where it is attached.
        slot: Slot,
        /// Its number.
        law: usize,
        /// How many laws there are.
        laws: usize,
    },
    /// The tolerance of Newton's iteration would end it anywhere.
    #[error("the tolerance of Newton's iteration is {tolerance}: give a relative error of s, from 0 to 0.1")]
    Tolerance {
        /// What was given.
        tolerance: f64,
    },
    /// Waves grow along the network beyond what a number holds.
    #[error(
        "at a growth rate of {sigma:.3e} 1/s waves grow {exponent:.0} times by e along the network, more than a number holds: \
         stay within {most:.3e} 1/s"
    )]
    Overflow {
        /// The growth rate, 1/s.
        sigma: f64,
        /// Its modulus times the travel time.
        exponent: f64,
        /// The largest modulus of a growth rate that is safe.
        most: f64,
    },
    /// Too many stations are asked for.
    #[error("{samples} samples of each of {segments} segments are more than {most} stations: ask for fewer")]
    Samples {
        /// How many of each segment.
        samples: usize,
        /// How many segments.
        segments: usize,
        /// Most stations.
        most: usize,
    },
    /// A flow is too fast for the closures used.
    #[error("duct {index}: the Mach number is {mach:.3}, but must be below 0.3: check the flow and its unit")]
    TooFast {
        /// Number of the duct, from 0.
        index: usize,
        /// Its Mach number.
        mach: f64,
    },
    /// Heat or a law at the upstream end of the first duct, which has nothing before it.
    #[error("duct 0: nothing may heat or act at the inlet of a chain with flow: put a duct before it")]
    ActionAtInlet,
    /// A source inside a chain with flow.
    #[error("with flow only a wave that enters at an end can drive the chain, not a source at place {place}")]
    SourceInFlow {
        /// The place.
        place: usize,
    },
    /// Between a place and its velocity reference downstream, another place answers to a velocity elsewhere.
    #[error(
        "duct {place} answers to a velocity downstream, beyond or at duct {other}, which itself answers to a velocity \
         elsewhere: let one of them answer to the velocity in front of it"
    )]
    ReferenceCrossed {
        /// Duct at whose upstream end the action is.
        place: usize,
        /// The other one.
        other: usize,
    },
    /// A sound speed or density of a chain with flow, where both follow from the inlet and the temperature
    /// ratios.
    #[error(
        "{slot:?} follows from the inlet and the temperature ratios of a chain with flow: attach the law to something else"
    )]
    SlotOfRest {
        /// The slot asked for.
        slot: Slot,
    },
    /// A law that moves the mean flow depends on s.
    #[error("{law} acts on the mean flow but depends on s: an area is the same for every s")]
    MeanFlowOfS {
        /// Name of the law.
        law: String,
    },
    /// A reflection law for a choked end.
    #[error("end {end} is choked: its reflection follows from the mean flow and takes no law")]
    ChokedEnd {
        /// 0 upstream, 1 downstream.
        end: usize,
    },
    /// There is no such duct, place or end of a chain with flow.
    #[error("duct, place or end {index} does not exist: the chain with flow has {ducts}")]
    NoDuct {
        /// The number asked for.
        index: usize,
        /// How many there are.
        ducts: usize,
    },
    /// A position is outside the tube.
    #[error("position {x} m is outside the network, which reaches from 0 to {length} m")]
    Outside {
        /// The position, m.
        x: f64,
        /// Length of the network, m.
        length: f64,
    },
    /// No segment ends at a position.
    #[error("no segment ends at {x} m (the network is {length} m long): cut it there first")]
    NoPlace {
        /// The position, m.
        x: f64,
        /// Length of the network, m.
        length: f64,
    },
    /// No stretch of the network leads from one place to the other.
    #[error(
        "there is no way downstream from place {from} to place {to}: give the place upstream first; the network has places 0 to {segments}"
    )]
    Stretch {
        /// Where it begins.
        from: usize,
        /// Where it ends.
        to: usize,
        /// Number of segments.
        segments: usize,
    },
    /// There is no such slot.
    #[error("{slot:?} does not exist: the network has segments 0 to {} and places 0 to {segments}", segments - 1)]
    Slot {
        /// The slot asked for.
        slot: Slot,
        /// Number of segments.
        segments: usize,
    },
    /// Newton's iteration did not settle.
    #[error("Newton's iteration did not converge in {steps} steps; relative residual {residual:.2e}")]
    NotConverged {
        /// Number of steps taken.
        steps: usize,
        /// |Newton step| / |s| at the end.
        residual: f64,
    },
    /// Newton's iteration settled on a root far from the guess.
    #[error("the root found, {to}, is too far from the guess {from}: another branch")]
    LostBranch {
        /// The guess.
        from: C64,
        /// The root found.
        to: C64,
    },
    /// A coefficient is not a finite number.
    #[error(
        "the network is not finite at s = {s:.2}: a law has a pole or is undefined there, as an `unflanged` end beyond |k a| = 2, a `flanged` one beyond 8, and an \
         impedance of -1"
    )]
    NotFinite {
        /// Where.
        s: C64,
    },
    /// Entropy waves of a mode that decays grow downstream beyond what a number holds.
    #[error(
        "at a growth rate of {sigma} 1/s entropy waves grow {exponent:.0} times by e while the mean flow carries them through the ducts: they drown the sound. \
         Leave them out (entropy_waves = false), as shear does in slow flows, or search above {least:.0} 1/s"
    )]
    EntropyWaves {
        /// The lowest growth rate of the region, 1/s.
        sigma: f64,
        /// Its size times the time that the flow takes.
        exponent: f64,
        /// The lowest growth rate that can be searched, 1/s.
        least: f64,
    },
    /// A region of the s-plane is empty or has no finite size.
    #[error(
        "the region {sigma:?} 1/s by {:.1} to {:.1} Hz is empty: give finite limits, the lower one first",
        omega[0] / TAU, omega[1] / TAU
    )]
    Region {
        /// Limits of the growth rate.
        sigma: [f64; 2],
        /// Limits of the angular frequency.
        omega: [f64; 2],
    },
    /// A region of the s-plane would hold far more modes than plane waves make sense for.
    #[error("the region {sigma:?} 1/s by {:.1} to {:.1} Hz would hold about {modes:.1e} modes: narrow it", omega[0] / TAU, omega[1] / TAU)]
    TooLarge {
        /// Limits of the growth rate.
        sigma: [f64; 2],
        /// Limits of the angular frequency.
        omega: [f64; 2],
        /// Estimate of the number of modes.
        modes: f64,
    },
    /// A law is not analytic in s, so that contour integrals and Newton's iteration mean nothing.
    #[error("{law} is not analytic in s near {s}: its slopes along sigma and omega differ by {mismatch:.1e}")]
    NotAnalytic {
        /// Name of the law.
        law: String,
        /// Where.
        s: C64,
        /// Relative difference of d/d sigma and d/d(i omega).
        mismatch: f64,
    },
    /// A law with a pole acts on the properties or losses of a segment, where it becomes an essential
    /// singularity.
    #[error("{law} has a pole at {at} but acts inside a segment: let it act at a place or an end")]
    PoleInSegment {
        /// Name of the law.
        law: String,
        /// The pole.
        at: C64,
    },
    /// A root or pole lies on the border of the region, or the border crosses a branch cut.
    #[error(
        "the count along the border of the region fails near {s}: a mode, a pole or a branch cut lies there; move the border"
    )]
    Border {
        /// Where.
        s: C64,
    },
    /// The samples round a cell show a pole that no law declared.
    #[error("a law has an undeclared pole between {low} and {high}: declare it in Coefficients::poles")]
    UndeclaredPole {
        /// Lower left corner of the cell.
        low: C64,
        /// Upper right corner.
        high: C64,
    },
    /// The number of modes found is not the number counted.
    #[error("{found} of {counted} modes found in the region: the count is not certified")]
    Uncertified {
        /// The winding number of the characteristic function, poles removed.
        counted: i64,
        /// Modes found, with multiplicity.
        found: i64,
    },
    /// The pressure at the reference place vanishes.
    #[error("the mode has no pressure at the reference place {place}: choose another reference")]
    SilentReference {
        /// The place.
        place: usize,
    },
}

impl NetworkError {
    /// Whether another guess or another parameter value may succeed, so that a search can shorten its step.
    #[must_use]
    pub fn is_recoverable(&self) -> bool {
        matches!(
            self,
            Self::NotConverged { .. }
                | Self::LostBranch { .. }
                | Self::NotFinite { .. }
                | Self::SilentReference { .. }
                | Self::Property { .. }
                | Self::Overflow { .. }
                | Self::TooFast { .. }
        )
    }
}
