//! Holes with a bias flow through them, whose edge sheds vortices.

use rijke_numerics::{C64, Jet, howe, howe_parts};

/// What walls around a jet leave of its steady loss in the open, for the parts `[before, after]` of the areas
/// of the ducts that holes take: (0.707 sqrt(1 - before) + 1 - after)^2 over its value at 0, the law of
/// sharp-edged orifices (Idelchik 1986, chapter 4). A jet in a wide duct loses all its momentum however near
/// the next jet is; one that fills the duct loses none.
#[must_use]
pub fn steady_share([before, after]: [f64; 2]) -> f64 {
    let loss =
        |before: f64, after: f64| (0.707 * (1.0 - before).max(0.0).sqrt() + (1.0 - after).max(0.0)).powi(2);
    loss(before, after) / loss(0.0, 0.0)
}

/// A hole with a bias flow: impedance Z = drag + s (inertia + shed (2R/K_R - 1)), with K_R Howe's
/// conductivity at the Strouhal number omega R/U (Howe 1979, Proc. R. Soc. Lond. A 366; thickness in series
/// as in Hughes & Dowling 1990, J. Fluid Mech. 218). Without flow K_R = 2R.
///
/// Howe's hole is alone in a plane. In a plate across a duct the attached mass is phi times as large (Fok)
/// and the steady loss q times ([`steady_share`]): pi R phi/2 is shed, and the Strouhal number is that of
/// the radius R phi/q, so that the resistance is 2 rho U q at low frequencies and pi rho U q/2 at high
/// ones, and the mass that the flow takes away there no more than what was attached.
#[derive(Clone, Debug, PartialEq)]
pub struct BiasHole {
    /// Without the vortices, times the area of the duct over that of the holes for a plate: Pa s/m.
    pub drag: f64,
    /// rho l_eff without flow, times the same, kg/m^2.
    pub inertia: f64,
    /// rho pi R/2, times the same and what the walls of the duct leave of it: the inertia of K_R.
    pub shed: f64,
    /// R/U, s, with U the velocity averaged over the hole; times phi/q in a duct.
    pub time: f64,
    /// What it closes.
    pub of: Behind,
}

/// What lies behind a hole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Behind {
    /// The next duct: k_mu = Z.
    Duct,
    /// A volume on the wall: k_ep = s/(s Z + stiffness).
    Volume {
        /// rho c^2 times the area of the neck over the volume, Pa/m; all of it, as Z, times the area of the
        /// duct over that of the neck.
        stiffness: f64,
    },
}

impl BiasHole {
    /// Strouhal number omega R/U above which K_R has no zero: 3, by the argument principle for |Im kappa| up
    /// to 1e4, and a margin.
    pub(super) const SHED_BELOW: f64 = 4.0;

    pub(super) fn at(&self, s: &Jet) -> Jet {
        let length = self.conductivity(s).recip().shift(-C64::ONE).scale(C64::new(self.shed, 0.0));
        let z = (s * &length.shift(C64::new(self.inertia, 0.0))).shift(C64::new(self.drag, 0.0));
        match self.of {
            Behind::Duct => z,
            Behind::Volume { stiffness } => s / &(s * &z).shift(C64::new(stiffness, 0.0)),
        }
    }

    /// What is zero at the poles and has none: what [`BiasHole::at`] divides by, times what K_R/(2R) divides
    /// by.
    pub(super) fn divisor(&self, s: &Jet) -> Jet {
        let z = s.scale(C64::new(self.time, 0.0));
        let [above, below] = howe_parts(z.value()).map(|[v, d, dd]| z.compose(v, d, dd));
        match self.of {
            Behind::Duct => above,
            Behind::Volume { stiffness } => {
                let rest = s.scale(C64::new(self.inertia - self.shed, 0.0)).shift(C64::new(self.drag, 0.0));
                let open = &above * &(s * &rest).shift(C64::new(stiffness, 0.0));
                &open + &(&(s * s).scale(C64::new(self.shed, 0.0)) * &below)
            }
        }
    }

    /// K_R/(2R).
    fn conductivity(&self, s: &Jet) -> Jet {
        let [value, slope, curvature] = howe(s.value() * self.time);
        s.scale(C64::new(self.time, 0.0)).compose(value, slope, curvature)
    }
}
