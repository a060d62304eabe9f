//! The numbers of a chain that laws attach to.

/// A number of the network that laws can change: its value is the constant in the network plus the sum of
/// weight times law over everything attached to it.
///
/// Segments are numbered 0 .. N-1 from the upstream end; places 0 .. N, place j lying upstream of segment j,
/// so that place 0 is the upstream end and place N the downstream end. Feedback coefficients follow equations
/// (1) and (2): p2 - p1 = -k_mu u1 - k_mp p1, u2 - u1 = -k_eu u1 - k_ep p1, with upstream-side values on the
/// right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Slot {
    /// Length of a segment, m.
    Length(usize),
    /// Cross-section of a segment, m^2.
    Area(usize),
    /// Speed of sound of a segment, m/s.
    SoundSpeed(usize),
    /// Density of a segment, kg/m^3.
    Density(usize),
    /// Viscous loss per metre of a segment (k_mu per metre), Pa s/m^2.
    Viscous(usize),
    /// Thermal loss per metre of a segment (k_ep per metre), 1/(Pa s).
    Thermal(usize),
    /// k_mu at a place, Pa s/m.
    Mu(usize),
    /// k_mp at a place, dimensionless.
    Mp(usize),
    /// k_eu at a place, dimensionless. An area change adds 1 - A1/A2 to it by itself.
    Eu(usize),
    /// k_ep at a place, m/(Pa s).
    Ep(usize),
    /// Reflection coefficient f/g at the upstream end, with respect to rho c of the first segment.
    Upstream,
    /// Reflection coefficient g/f at the downstream end, with respect to rho c of the last segment.
    Downstream,
}

impl Slot {
    /// Number of its segment or place; none for an end.
    pub(crate) fn index(self) -> Option<usize> {
        match self {
            Self::Length(i) | Self::Area(i) | Self::SoundSpeed(i) | Self::Density(i) => Some(i),
            Self::Viscous(i) | Self::Thermal(i) => Some(i),
            Self::Mu(j) | Self::Mp(j) | Self::Eu(j) | Self::Ep(j) => Some(j),
            Self::Upstream | Self::Downstream => None,
        }
    }
}
