//! The dense route to the same eigenvalue: what the sweep is measured against.

use crate::{A, WALL};
use rijke_network::Network;
use rijke_numerics::{C64, complex_lu_solve};

/// The same characteristic equation as a dense 2N x 2N system in the wave amplitudes, through the LU of the
/// linear-algebra library, one factorisation per step.
pub(crate) fn newton(net: &Network, guess: C64) -> C64 {
    let n = net.segments().len();
    let size = 2 * n;
    let matrix = |s: C64| {
        let mut a = vec![C64::ZERO; size * size];
        let loss = WALL.paper(s);
        let r = C64::from_polar(A[5], A[6]);
        let line = |i: usize| {
            let g = net.segments()[i];
            let z = s * g.density + loss.viscous[0];
            let y = s / (g.density * g.sound_speed * g.sound_speed) + loss.thermal[0];
            (z.sqrt() * y.sqrt() * g.length, z.sqrt() / y.sqrt())
        };
        // Unknowns f_i, g_i at the upstream end of segment i.
        let (_, zc) = line(0);
        let rho_c = net.segments()[0].impedance();
        let u = |sign: f64, zc: C64| sign / zc;
        // p (1 - R) = rho c u (1 + R) (-1): f + g and (f - g)/zc with R_u.
        for (column, sign) in [(0, 1.0), (1, -1.0)] {
            a[column] = (1.0 - r) + (1.0 + r) * rho_c * u(sign, zc);
        }
        for i in 0..n - 1 {
            let ((gl, zc), (_, zn)) = (line(i), line(i + 1));
            let wave = [(-gl).exp(), gl.exp()];
            let k = if i + 1 == n / 4 {
                let heat = A[7] - A[1] * (-s * A[2]).exp();
                [A[3] + s * (1e-3 * A[4]), C64::ZERO, heat, C64::new(1e-6 * A[3], 0.0)]
            } else {
                [C64::ZERO; 4]
            };
            for (w, sign) in [(0, 1.0), (1, -1.0)] {
                let (p, v) = (wave[w], u(sign, zc) * wave[w]);
                let row = (2 * i + 1) * size;
                a[row + 2 * i + w] = p - k[0] * v - k[1] * p;
                a[row + 2 * i + 2 + w] = -C64::ONE;
                let row = row + size;
                a[row + 2 * i + w] = v - k[2] * v - k[3] * p;
                a[row + 2 * i + 2 + w] = -u(sign, zn);
            }
        }
        let (gl, zc) = line(n - 1);
        let rho_c = net.segments()[n - 1].impedance();
        for (w, (sign, e)) in [(1.0, (-gl).exp()), (-1.0, gl.exp())].into_iter().enumerate() {
            a[(size - 1) * size + 2 * n - 2 + w] = ((1.0 - r) - (1.0 + r) * rho_c * u(sign, zc)) * e;
        }
        a
    };
    // The last row is moved to a bordering condition: with b the last unit vector and g = 1 fixed, the
    // residual is a scalar function of s.
    let residual = |s: C64| {
        let mut a = matrix(s);
        let last: Vec<C64> = a[(size - 1) * size..].to_vec();
        for (column, v) in a[(size - 1) * size..].iter_mut().enumerate() {
            *v = if column == 1 { C64::ONE } else { C64::ZERO };
        }
        let mut b = vec![C64::ZERO; size];
        b[size - 1] = C64::ONE;
        let x = complex_lu_solve(&a, &b).unwrap();
        last.iter().zip(&x).map(|(l, x)| l * x).sum::<C64>()
    };
    // One factorisation per step: secant, started by a step of 1e-3.
    let (mut s, mut before) = (guess, guess + 1e-3);
    let mut f_before = residual(before);
    for _ in 0..10 {
        let f = residual(s);
        let step = -f * (s - before) / (f - f_before);
        (before, f_before) = (s, f);
        s += step;
        if step.norm() < 1e-9 * s.norm() {
            break;
        }
    }
    s
}
