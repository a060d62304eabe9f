//! The heated tube cut into cells: geometry and closures, ready for the kernels.

use super::air::Air;
use super::closures::Closures;
use super::convection::Convection;
use crate::apparatus::geometry::TubeRig;
use crate::error::FlowError;
use rijke_rig::Gas;

/// A vertical tube with a heater at one place.
#[derive(Clone, Debug)]
pub struct Pipe {
    pub(crate) gas: Gas,
    pub(crate) air: Air,
    pub(crate) closures: Closures,
    pub(crate) area: f64,
    pub(crate) diameter: f64,
    pub(crate) outer_diameter: f64,
    pub(crate) wall_area: f64,
    pub(crate) length: f64,
    /// Natural convection outside.
    pub(crate) outside: Convection,
    pub(crate) heater: f64,
    pub(crate) faces: Vec<f64>,
    pub(crate) cells: Vec<Cell>,
    /// Faces at the lower and upper edge of the heater.
    pub(crate) edges: [usize; 2],
    /// Places of the microphones, m, and their faces.
    pub(crate) microphones: Vec<(f64, usize)>,
}

/// What a cell knows.
#[derive(Clone, Debug)]
pub(crate) struct Cell {
    pub(crate) length: f64,
    /// Development of the thermal boundary layer for upward and for downward flow.
    pub(crate) entry: [Entry; 2],
    /// Mean of exp(-xi/jet length) above the heater (below it, for downward flow), else 0.
    pub(crate) jet: [f64; 2],
    /// Shares of the heater, of the wires, of the radiated power, and of both mounts.
    pub(crate) heater: f64,
    pub(crate) wire: f64,
    pub(crate) radiated: f64,
    pub(crate) mount: f64,
    /// Friction with insert over friction without.
    pub(crate) friction: f64,
}

/// Distance from where the boundary layer starts, at the two faces in the direction of the flow, to the power
/// 2/3.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    pub(crate) low: f64,
    pub(crate) high: f64,
}

impl Pipe {
    /// A tube with the heater's centre at `heater` (m). `refinement` multiplies the number of cells: 1 gives
    /// about 60 cells and 0.05 us in the arrival times (`docs/theory/flow.md` shows the convergence).
    ///
    /// Faces lie on the edges of heater and mounts and on the microphones, so that shares and observations
    /// are exact; cells shrink quadratically towards the inlet and the heater, where boundary layers start.
    ///
    /// # Errors
    /// [`FlowError::Heater`] if the heater does not fit into the tube, [`FlowError::Closure`] for a closure
    /// out of range, [`FlowError::Setting`] for a length, a diameter, a wall or a pressure that is not
    /// positive.
    pub fn new(rig: &TubeRig, closures: &Closures, heater: f64, refinement: u32) -> Result<Self, FlowError> {
        check(closures)?;
        let sizes = [
            ("length", rig.tube.length),
            ("inner_diameter", rig.tube.inner_diameter),
            ("wall_thickness", rig.tube.wall_thickness),
            ("pressure", rig.pressure),
        ];
        if let Some(&(name, value)) = sizes.iter().find(|(_, v)| !(*v > 0.0 && v.is_finite())) {
            return Err(FlowError::Setting { name, value, must: "positive and finite, in SI units" });
        }
        let (length, half) = (rig.tube.length, 0.5 * rig.plates.length());
        if !(heater > half && heater < length - half) {
            return Err(FlowError::Heater { position: heater, low: half, high: length - half });
        }
        let reach = 0.5 * closures.mount_length;
        let mut marks = vec![0.0, heater - half, heater, heater + half, length];
        marks.extend(closures.mounts.iter().flat_map(|m| [m - reach, m + reach]));
        marks.extend(&rig.microphones.positions);
        let faces = faces(marks, length, heater, refinement.max(1));
        let face_at = |x: f64| nearest(&faces, x);
        let edges = [face_at(heater - half), face_at(heater + half)];
        let microphones = rig.microphones.positions.iter().map(|&x| (x, face_at(x))).collect();
        let insert = 1.0 + rig.insert.perimeter() / rig.tube.perimeter();
        let cells =
            faces.windows(2).map(|f| cell(f[0], f[1], length, heater, half, closures, insert)).collect();
        let outer_diameter = rig.tube.inner_diameter + 2.0 * rig.tube.wall_thickness;
        let quarter = 0.25 * std::f64::consts::PI;
        Ok(Self {
            gas: rig.gas.clone(),
            air: Air::new(&rig.gas, rig.pressure),
            closures: closures.clone(),
            area: rig.tube.area(),
            diameter: rig.tube.inner_diameter,
            outer_diameter,
            wall_area: quarter * (outer_diameter.powi(2) - rig.tube.inner_diameter.powi(2)),
            length,
            outside: Convection::new(length, outer_diameter),
            heater,
            faces,
            cells,
            edges,
            microphones,
        })
    }

    /// The same tube with other closures and the heater moved by `shift` (m): the grid is stretched along, so
    /// that everything depends smoothly on the shift. Faces then lie beside the microphones by less than the
    /// shift.
    ///
    /// # Errors
    /// [`FlowError::Closure`] for a closure out of range, [`FlowError::Heater`] for a heater outside the
    /// tube.
    pub(crate) fn altered(&self, shift: f64, closures: &Closures) -> Result<Self, FlowError> {
        check(closures)?;
        let [low, high] = self.edges.map(|e| self.faces[e]);
        let (half, heater) = (0.5 * (high - low), self.heater + shift);
        if !(heater > half && heater < self.length - half) {
            return Err(FlowError::Heater { position: heater, low: half, high: self.length - half });
        }
        let stretched =
            |x: f64| x + shift * (x / low).min((self.length - x) / (self.length - high)).clamp(0.0, 1.0);
        let faces: Vec<f64> = self.faces.iter().map(|&x| stretched(x)).collect();
        let cells = (faces.windows(2).zip(&self.cells))
            .map(|(f, old)| cell(f[0], f[1], self.length, heater, half, closures, old.friction))
            .collect();
        Ok(Self { closures: closures.clone(), heater, faces, cells, ..self.clone() })
    }

    /// Places of the faces, m.
    #[must_use]
    pub fn faces(&self) -> &[f64] {
        &self.faces
    }

    /// Centre of the heater, m.
    #[must_use]
    pub fn heater(&self) -> f64 {
        self.heater
    }

    /// Places of the microphones, m.
    pub fn microphones(&self) -> impl Iterator<Item = f64> + '_ {
        self.microphones.iter().map(|m| m.0)
    }

    /// Number of cells.
    #[must_use]
    pub fn size(&self) -> usize {
        self.cells.len()
    }

    /// Heat capacity of the wall per length, J/(m K).
    pub(crate) fn wall_capacity(&self) -> f64 {
        self.closures.wall_heat_capacity * self.wall_area
    }

    /// Conductance of the wall between cells i and i + 1, W/K.
    pub(crate) fn conductance(&self, i: usize) -> f64 {
        let distance = 0.5 * (self.cells[i].length + self.cells[i + 1].length);
        self.closures.wall_conductivity * self.wall_area / distance
    }
}

fn check(closures: &Closures) -> Result<(), FlowError> {
    let c = closures;
    let positive = [
        ("wire_length", c.wire_length),
        ("heater_lag", c.heater_lag),
        ("jet_length", c.jet_length),
        ("mount_length", c.mount_length),
        ("wall_heat_capacity", c.wall_heat_capacity),
        ("radiated_length", c.radiated_length),
        ("profile_factor", c.profile_factor),
    ];
    let not_negative = [
        ("entrance_loss", c.entrance_loss),
        ("development_loss", c.development_loss),
        ("wire_share", c.wire_share),
        ("orifice_length", c.orifice_length),
        ("emissivity", c.emissivity),
        ("wall_conductivity", c.wall_conductivity),
        ("radiated_share", c.radiated_share),
    ];
    let places = c.mounts.map(|x| ("mounts", x));
    let bad =
        positive.iter().find(|(_, v)| !v.is_finite() || *v <= 0.0).map(|bad| (bad, "positive and finite"));
    let bad = bad.or_else(|| {
        let wrong = not_negative.iter().find(|(_, v)| !v.is_finite() || *v < 0.0);
        wrong
            .or_else(|| places.iter().find(|(_, x)| !x.is_finite()))
            .map(|bad| (bad, "zero or more and finite"))
    });
    if let Some((&(name, value), need)) = bad {
        return Err(FlowError::Closure { name, value, need });
    }
    let shares =
        [("wire_share", c.wire_share), ("emissivity", c.emissivity), ("radiated_share", c.radiated_share)];
    if let Some(&(name, value)) = shares.iter().find(|(_, v)| *v > 1.0) {
        return Err(FlowError::Closure { name, value, need: "at most 1" });
    }
    // Infinite for no boundary layer at the wall.
    let (name, value, need) = ("pulse_frequency", c.pulse_frequency, "positive");
    if value > 0.0 { Ok(()) } else { Err(FlowError::Closure { name, value, need }) }
}

/// Cells of about 20 mm, in tubes beyond 10 m of a five-hundredth of the length, and quadratic grading away
/// from the starts of boundary layers.
fn faces(mut marks: Vec<f64>, length: f64, heater: f64, refinement: u32) -> Vec<f64> {
    let coarse = 0.02_f64.max(length / 500.0);
    marks.retain(|&x| (0.0..=length).contains(&x));
    marks.sort_by(f64::total_cmp);
    marks.dedup_by(|b, a| *b - *a < 1e-9);
    let mut faces = vec![0.0];
    for pair in marks.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let graded = from == 0.0 || from == heater;
        let least = if graded { 3.0 } else { 1.0 };
        let count = ((to - from) / coarse).ceil().max(least) as u32 * refinement;
        for k in 1..=count {
            let share = f64::from(k) / f64::from(count);
            faces.push(if k == count {
                to
            } else {
                from + (to - from) * if graded { share * share } else { share }
            });
        }
    }
    faces
}

fn nearest(faces: &[f64], x: f64) -> usize {
    let upper = faces.partition_point(|&f| f < x).clamp(1, faces.len() - 1);
    if x - faces[upper - 1] < faces[upper] - x { upper - 1 } else { upper }
}

fn cell(low: f64, high: f64, length: f64, heater: f64, half: f64, closures: &Closures, insert: f64) -> Cell {
    let middle = 0.5 * (low + high);
    let above = middle > heater;
    let overlap = |a: f64, b: f64| (high.min(b) - low.max(a)).max(0.0);
    // Integral over the cell of exp(-distance/scale)/scale, distance measured from `start` away from the
    // source.
    let decay = |near: f64, far: f64, scale: f64| (-near / scale).exp() - (-far / scale).exp();
    let entry = |start: f64, end: f64| Entry { low: start.cbrt().powi(2), high: end.cbrt().powi(2) };
    let jet =
        |near: f64, far: f64| decay(near, far, closures.jet_length) * closures.jet_length / (far - near);
    let wire = if above {
        0.0
    } else {
        let scale = closures.wire_length;
        decay(heater - high, heater - low, scale) / (1.0 - (-heater / scale).exp())
    };
    let scale = closures.radiated_length;
    let both_sides = 2.0 - (-heater / scale).exp() - (-(length - heater) / scale).exp();
    let (near, far) = if above { (low - heater, high - heater) } else { (heater - high, heater - low) };
    let reach = 0.5 * closures.mount_length;
    let mounts = closures.mounts.iter().map(|m| overlap(m - reach, m + reach) / closures.mount_length);
    Cell {
        length: high - low,
        entry: if above {
            [entry(near, far), entry(length - high, length - low)]
        } else {
            [entry(low, high), entry(near, far)]
        },
        jet: if above { [jet(near, far), 0.0] } else { [0.0, jet(near, far)] },
        heater: overlap(heater - half, heater + half) / (2.0 * half),
        wire,
        radiated: decay(near, far, scale) / both_sides,
        mount: mounts.sum(),
        friction: if above { 1.0 } else { insert },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn exact_shares_sum_to_one_on_every_grid() {
        for heater in [0.05, 0.25, 0.5, 0.85] {
            for refinement in [1, 3] {
                let pipe = Pipe::new(&TubeRig::juniper_yoko_2022(), &Closures::default(), heater, refinement)
                    .unwrap();
                let sum = |f: fn(&Cell) -> f64| pipe.cells.iter().map(f).sum::<f64>();
                assert_relative_eq!(sum(|c| c.length), 1.0, epsilon = 1e-14);
                assert_relative_eq!(sum(|c| c.heater), 1.0, epsilon = 1e-12);
                assert_relative_eq!(sum(|c| c.wire), 1.0, epsilon = 1e-12);
                assert_relative_eq!(sum(|c| c.radiated), 1.0, epsilon = 1e-12);
                assert_relative_eq!(sum(|c| c.mount), 2.0, epsilon = 1e-12);
                for (x, face) in &pipe.microphones {
                    assert_eq!(*x, pipe.faces[*face]);
                }
            }
        }
    }

    #[test]
    fn exact_a_heater_outside_the_tube_is_refused() {
        let refused = Pipe::new(&TubeRig::juniper_yoko_2022(), &Closures::default(), 0.999, 1);
        assert!(matches!(refused, Err(FlowError::Heater { .. })));
        let bad = Closures { jet_length: 0.0, ..Closures::default() };
        let refused = Pipe::new(&TubeRig::juniper_yoko_2022(), &bad, 0.25, 1);
        assert!(matches!(refused, Err(FlowError::Closure { name: "jet_length", .. })));
        let default = Closures::default;
        for (bad, name) in [
            (Closures { heater_lag: f64::INFINITY, ..default() }, "heater_lag"),
            (Closures { wire_share: f64::INFINITY, ..default() }, "wire_share"),
            (Closures { mounts: [0.1, f64::NAN], ..default() }, "mounts"),
            (Closures { pulse_frequency: 0.0, ..default() }, "pulse_frequency"),
            (Closures { emissivity: 5.0, ..default() }, "emissivity"),
            (Closures { wire_share: 2.0, ..default() }, "wire_share"),
        ] {
            let refused = Pipe::new(&TubeRig::juniper_yoko_2022(), &bad, 0.25, 1).map(|_| ());
            assert!(refused.unwrap_err().to_string().starts_with(&format!("the closure {name} is ")));
        }
        for (change, name) in [
            ((|t| t.inner_diameter = 0.0) as fn(&mut crate::Tube), "inner_diameter"),
            (|t| t.inner_diameter = f64::NAN, "inner_diameter"),
            (|t| t.inner_diameter = -0.05, "inner_diameter"),
            (|t| t.wall_thickness = 0.0, "wall_thickness"),
        ] {
            let mut rig = TubeRig::juniper_yoko_2022();
            change(&mut rig.tube);
            let words = Pipe::new(&rig, &default(), 0.25, 1).map(|_| ()).unwrap_err().to_string();
            assert!(words.starts_with(&format!("{name} = ")), "{words}");
        }
        let no_layer = Closures { pulse_frequency: f64::INFINITY, ..default() };
        assert!(Pipe::new(&TubeRig::juniper_yoko_2022(), &no_layer, 0.25, 1).is_ok());
    }
}
