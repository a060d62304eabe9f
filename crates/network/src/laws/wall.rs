//! Viscous and thermal losses at the wall of a tube, per metre, as analytic laws of s.

use rijke_numerics::C64;
pub use rijke_numerics::special::bessel_ratio;

/// What a wall law needs to know of the gas and the tube; SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    /// Density, kg/m^3.
    pub density: f64,
    /// Speed of sound, m/s.
    pub sound_speed: f64,
    /// Dynamic viscosity, Pa s.
    pub viscosity: f64,
    /// Prandtl number.
    pub prandtl: f64,
    /// Ratio of specific heats.
    pub gamma: f64,
    /// Diameter, m; for another cross-section the hydraulic diameter, 4 area / perimeter.
    pub diameter: f64,
}

/// Which law of wall losses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WallLaw {
    /// The paper's, section 6.1.
    Paper,
    /// Kirchhoff's.
    Kirchhoff,
    /// Zwikker and Kosten's.
    ZwikkerKosten,
}

impl WallLaw {
    pub(crate) fn loss(self, wall: &Wall, s: C64) -> Loss {
        match self {
            Self::Paper => wall.paper(s),
            Self::Kirchhoff => wall.kirchhoff(s),
            Self::ZwikkerKosten => wall.zwikker_kosten(s),
        }
    }
}

/// Loss per metre: k_mu/dx (Pa s/m^2) and k_ep/dx (1/(Pa s)), each with its first and second derivative in s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loss {
    /// Viscous: dp/dx = -(s rho + viscous) u.
    pub viscous: [C64; 3],
    /// Thermal: du/dx = -(s/(rho c^2) + thermal) p.
    pub thermal: [C64; 3],
}

impl Wall {
    /// The paper's law (section 6.1): viscous (4/D) sqrt(s rho mu), thermal (gamma-1)/(rho c)^2 (4/D) sqrt(s
    /// rho mu) Pr^{-2/3}. The paper writes sqrt(i omega ...); this is its analytic continuation to complex s.
    #[must_use]
    pub fn paper(&self, s: C64) -> Loss {
        self.boundary_layer(s, self.paper_factor())
    }

    /// Kirchhoff's law for a boundary layer thin against the radius: as [`Wall::paper`] with Pr^{-1/2}
    /// (Kirchhoff 1868; Rayleigh, Theory of Sound, art. 348-350).
    #[must_use]
    pub fn kirchhoff(&self, s: C64) -> Loss {
        self.boundary_layer(s, self.kirchhoff_factor())
    }

    /// Thin boundary layers: k_mu/dx = (4/D) sqrt(s rho mu) and k_ep/dx = `thermal_factor` (gamma-1)/(rho
    /// c)^2 times it.
    fn boundary_layer(&self, s: C64, thermal_factor: f64) -> Loss {
        let root = s.sqrt() * self.layer();
        let viscous = [root, 0.5 * root / s, -0.25 * root / (s * s)];
        let ratio = self.layer_of_heat(thermal_factor);
        Loss { viscous, thermal: viscous.map(|v| v * ratio) }
    }

    /// Viscous loss of a thin boundary layer over sqrt s.
    fn layer(&self) -> f64 {
        (self.density * self.viscosity).sqrt() * (4.0 / self.diameter)
    }

    /// Thermal loss of a thin boundary layer over the viscous one.
    fn layer_of_heat(&self, thermal_factor: f64) -> f64 {
        thermal_factor * (self.gamma - 1.0) / (self.density * self.sound_speed).powi(2)
    }

    /// The viscous or the thermal loss over sqrt s, where a law has one: not [`Wall::zwikker_kosten`].
    pub(super) fn thin(&self, law: WallLaw, viscous: bool) -> Option<f64> {
        let factor = match law {
            WallLaw::ZwikkerKosten => return None,
            _ if viscous => return Some(self.layer()),
            WallLaw::Paper => self.paper_factor(),
            WallLaw::Kirchhoff => self.kirchhoff_factor(),
        };
        Some(self.layer() * self.layer_of_heat(factor))
    }

    fn paper_factor(&self) -> f64 {
        self.prandtl.powf(-2.0 / 3.0)
    }

    fn kirchhoff_factor(&self) -> f64 {
        self.prandtl.sqrt().recip()
    }

    /// The line of Zwikker and Kosten (1949, chapter II): with K(z) = 2 I1(z)/(z I0(z)) and z = (D/2) sqrt(s
    /// rho/mu), Z = s rho/(1 - K(z)) and Y = s/(rho c^2) (1 + (gamma-1) K(z sqrt Pr)). Exact to the order
    /// (radius/wavelength)^2 for any ratio of boundary layer to radius; tends to Kirchhoff's law for thin
    /// layers.
    #[must_use]
    pub fn zwikker_kosten(&self, s: C64) -> Loss {
        let scale = 0.5 * self.diameter * (self.density / self.viscosity).sqrt();
        let root = s.sqrt();
        // d/ds through z = scale sqrt s: K_s = K' z/(2s), K_ss = K'' (z/2s)^2 - K' z/(4 s^2).
        let in_s = |scale: f64| {
            let z = scale * root;
            let [k, k1, k2] = mean_profile(z);
            let (z1, z2) = (z / (2.0 * s), -z / (4.0 * s * s));
            [k, k1 * z1, k2 * z1 * z1 + k1 * z2]
        };
        let [k, k1, k2] = in_s(scale);
        let [h, h1, h2] = in_s(scale * self.prandtl.sqrt());
        let rho = self.density;
        // Viscous part: s rho (1/(1-K) - 1) = s rho G with G = K/(1-K), G' = K'/(1-K)^2.
        let open = (1.0 - k).inv();
        let (g, g1) = (k * open, k1 * open * open);
        let g2 = (k2 + 2.0 * k1 * k1 * open) * open * open;
        let viscous = [s * g, g + s * g1, 2.0 * g1 + s * g2].map(|v| v * rho);
        let ratio = (self.gamma - 1.0) / (rho * self.sound_speed * self.sound_speed);
        let thermal = [s * h, h + s * h1, 2.0 * h1 + s * h2].map(|v| v * ratio);
        Loss { viscous, thermal }
    }
}

/// K(z) = 2 I1(z)/(z I0(z)) with K' and K'', for Re z >= 0.
///
/// With r = I1/I0: r' = 1 - r/z - r^2, so K = 2r/z follows K' = 2/z - 2K/z - z K^2/2.
fn mean_profile(z: C64) -> [C64; 3] {
    let ratio = bessel_ratio(z);
    let k = 2.0 * ratio / z;
    let k1 = (2.0 - 2.0 * k) / z - 0.5 * z * k * k;
    let k2 = -(2.0 - 2.0 * k) / (z * z) - 2.0 * k1 / z - 0.5 * k * k - z * k * k1;
    [k, k1, k2]
}
