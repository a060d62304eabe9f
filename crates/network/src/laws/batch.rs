//! Losses at many walls without derivatives, those of Zwikker and Kosten side by side.

use crate::chain::block::{LANES, Row};
use crate::chain::coefficients::Laws;
use crate::laws::wall::{Wall, WallLaw};
use pulp::Simd;
use rijke_numerics::C64;
use rijke_numerics::special::bessel_ratios;
use rijke_numerics::wide::Wide;

/// Laws of walls that wait for their neighbours, a lane each.
pub(super) struct WallBatch {
    s: C64,
    root: C64,
    count: usize,
    law: [usize; LANES],
    /// (z/sqrt s)^2.
    square: [f64; LANES],
    /// rho, or (gamma - 1)/(rho c^2).
    factor: [f64; LANES],
    /// 1 for the viscous loss, 0 for the thermal one.
    viscous: [f64; LANES],
    loss: Row,
}

impl WallBatch {
    pub(super) fn new(s: C64) -> Self {
        let ones = [1.0; LANES];
        let (square, factor, viscous) = (ones, ones, ones);
        Self { s, root: s.sqrt(), count: 0, law: [0; LANES], square, factor, viscous, loss: Row::ZERO }
    }

    /// Adds the viscous or the thermal loss at a wall, for law number `law`.
    #[inline]
    pub(super) fn push(&mut self, law: usize, kind: WallLaw, viscous: bool, wall: &Wall, laws: &mut Laws) {
        if let Some(thin) = wall.thin(kind, viscous) {
            return laws.set_analytic(law, [thin * self.root, C64::ZERO, C64::ZERO]);
        }
        let i = self.count;
        let square = 0.25 * wall.diameter * wall.diameter * wall.density / wall.viscosity;
        let thermal = || (wall.gamma - 1.0) / (wall.density * wall.sound_speed * wall.sound_speed);
        self.law[i] = law;
        (self.square[i], self.factor[i], self.viscous[i]) =
            if viscous { (square, wall.density, 1.0) } else { (square * wall.prandtl, thermal(), 0.0) };
        self.count += 1;
        if self.count == LANES {
            self.write(laws);
        }
    }

    /// Writes the laws that wait.
    pub(super) fn write(&mut self, laws: &mut Laws) {
        pulp::Arch::new().dispatch(&mut *self);
        for (i, law) in self.law[..self.count].iter().enumerate() {
            laws.set_analytic(*law, [self.loss.get(i), C64::ZERO, C64::ZERO]);
        }
        self.count = 0;
    }
}

impl pulp::WithSimd for &mut WallBatch {
    type Output = ();

    /// With K = 2r/z, r = I1/I0: s rho K/(1 - K) and s (gamma - 1)/(rho c^2) K; see [`Wall::zwikker_kosten`].
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (s, root) = (Wide::splat(simd, self.s), Wide::splat(simd, self.root));
        let (square, factor) = (S::as_simd_f64s(&self.square).0, S::as_simd_f64s(&self.factor).0);
        let viscous = S::as_simd_f64s(&self.viscous).0;
        for i in 0..self.count.div_ceil(S::F64_LANES) {
            let z = root.scale(simd.sqrt_f64s(square[i]));
            let ratio = bessel_ratios(z);
            let twice = ratio + ratio;
            let below = z - twice.scale(viscous[i]);
            self.loss.store(i, (s * twice * below.recip()).scale(factor[i]));
        }
    }
}
