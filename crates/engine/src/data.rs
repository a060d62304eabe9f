//! Observations as the data of an inference.

use crate::errors::{Assemblies, PointErrors, Scatter};
use crate::groups::Groups;
use crate::noise::{BETWEEN, NONE, Noise};
use crate::observed::{Observed, Used, same_installation};
use crate::{Conditions, EngineError};
use rijke_inference::{Data, NoiseMode, Observation, relative_noise};
use rijke_numerics::Matrix;
use rijke_study::{PartAt, Rig};
use std::collections::BTreeMap;

/// The data, and for each of their numbers its place in the prediction.
pub(crate) type Ordered = (Data, Vec<usize>);

/// Everything that the blocks of data are made of.
pub(crate) struct Blocks<'a> {
    pub(crate) rig: &'a Rig,
    pub(crate) observed: &'a [Observed],
    pub(crate) used: &'a [Used],
    pub(crate) noise: &'a Noise,
    /// Parameters that vary between installations.
    pub(crate) scatter: &'a [Scatter],
    /// Errors of assemblies that an earlier stage knows: they are no noise.
    pub(crate) assemblies: &'a Assemblies,
}

/// Most numbers of points that share a cause of error in one block, and most where pressures tell what varies
/// from installation to installation: a fit inverts the covariance of a block at every step.
const TOGETHER: usize = 64;
const TOGETHER_WHERE_ENDS_VARY: usize = 400;

/// A ratio of variances: that of a parameter between installations over the one with which pressures alone
/// determine it. From this ratio on, pressures must not count as draws of their own.
const TOLD: f64 = 0.1;

/// Whether all that was measured at points that share causes of error is one block of data: where errors of
/// factors are among these, which may move mode shapes as much as eigenvalues, or a parameter that varies
/// moves both, and the points are few.
pub(crate) fn is_one_block(
    errors: &PointErrors,
    group: &[usize],
    used: &[Used],
    scatter: &[Scatter],
) -> bool {
    let numbers = group.iter().map(|&p| used[p].rows.len()).sum::<usize>();
    let by_factors = || group.iter().any(|&p| errors.of_factors_at(p).next().is_some());
    (numbers <= TOGETHER && by_factors())
        || (numbers <= TOGETHER_WHERE_ENDS_VARY
            && scatter.iter().any(|s| is_told_by_pressures(s, group, used)))
}

/// Whether pressures tell of the draws of a parameter that varies, each by its measured standard deviation.
fn is_told_by_pressures(scatter: &Scatter, group: &[usize], used: &[Used]) -> bool {
    let sd = match scatter.group.mode {
        NoiseMode::Fixed { sd } => sd,
        NoiseMode::Inferred { median, .. } => median,
        NoiseMode::Floated => f64::INFINITY,
    };
    let of_point = |p: usize| {
        let pressures = used[p].rows.iter().enumerate().filter(|(_, row)| **row >= 2);
        let slopes = &scatter.slopes[p];
        pressures.map(|(k, row)| slopes[*row].powi(2) / used[p].covariance[(k, k)]).sum::<f64>()
    };
    let told: f64 = group.iter().map(|&p| of_point(p)).sum();
    told > 0.0 && sd * sd * told > TOLD
}

/// For each observation whether its numbers are in one block with those of all that share its causes of
/// error.
pub(crate) fn in_one_block(
    errors: &PointErrors,
    observed: &[Observed],
    used: &[Used],
    scatter: &[Scatter],
) -> Vec<bool> {
    let mut all = vec![false; observed.len()];
    if !errors.are_of_factors() && scatter.is_empty() {
        return all;
    }
    for group in errors.together(|a, b| same_installation(&observed[a], &observed[b])) {
        let one = is_one_block(errors, &group, used, scatter);
        group.into_iter().for_each(|p| all[p] = one);
    }
    all
}

impl Blocks<'_> {
    fn offsets(&self) -> Vec<usize> {
        let mut sum = 0;
        let offset = |u: &Used| {
            sum += u.size();
            sum - u.size()
        };
        self.used.iter().map(offset).collect()
    }

    fn groups(&self) -> (Groups, Vec<Option<Matrix>>) {
        let near: Vec<_> = self.observed.iter().zip(self.used).map(|(o, u)| self.near_field(o, u)).collect();
        let pressures = self.used.iter().any(|u| !u.others.is_empty());
        let groups =
            Groups::new(self.there(), pressures, self.noise).near_field(near.iter().any(Option::is_some));
        (groups, near)
    }

    /// Whether any growth rate, and any frequency, is among the data.
    fn there(&self) -> [bool; 2] {
        [0, 1].map(|row| self.used.iter().any(|u| u.rows.contains(&row)))
    }

    fn floor(&self, own: &Matrix) -> Option<Matrix> {
        self.noise.measured.then(|| own.clone())
    }

    /// One block per observation; every point is an installation of its own.
    ///
    /// # Errors
    /// [`EngineError::Inference`] for numbers that are not finite or covariances that are not positive
    /// definite.
    pub(crate) fn apart(&self) -> Result<Ordered, EngineError> {
        let (groups, near) = self.groups();
        let groups = groups.varying(self.scatter);
        let offsets = self.offsets();
        let (mut blocks, mut order) = (Vec::new(), Vec::new());
        for (p, ((o, u), near)) in self.observed.iter().zip(self.used).zip(&near).enumerate() {
            let places =
                |row: usize| -> Vec<usize> { (0..u.rows.len()).filter(|&k| u.rows[k] == row).collect() };
            let block = Observation::new(o.conditions.id.clone(), u.values.clone())
                .with_independent_noise(0, &places(0))
                .with_independent_noise(1, &places(1));
            let block = self.floor(&u.covariance).into_iter().fold(block, Observation::with_floor);
            let numbers: Vec<(usize, usize)> = u.rows.iter().map(|&row| (p, row)).collect();
            let varying = self.scatter.iter().map(|s| s.structure(&numbers, |_, _| false));
            let block = with(block, (groups.varying..).zip(varying));
            order.extend(u.rows.iter().map(|row| offsets[p] + row));
            if u.others.is_empty() {
                blocks.push(block);
                continue;
            }
            let own = [(2, padded(u, &relative_noise(&u.pressures)))];
            let near = groups.near_field.zip(near.as_ref()).map(|(group, near)| (group, padded(u, near)));
            blocks.push(with(block, near.into_iter().chain(own)));
        }
        Ok((Data::new(blocks, groups.list)?, order))
    }

    /// With the errors of the base states as a covariance that does not float, and what points of one
    /// installation share.
    ///
    /// Growth rates and frequencies of all points that share a cause of error are one block, so that what
    /// moves them together is known to, with all pressures of these points where [`is_one_block`] says so.
    /// Elsewhere the pressures of each point are a block of their own: what the errors do to pressures and
    /// eigenvalue together is left out, because larger blocks would make the inference many times slower.
    ///
    /// # Errors
    /// As [`Blocks::apart`].
    pub(crate) fn together(&self, errors: &PointErrors) -> Result<Ordered, EngineError> {
        let same = |a: usize, b: usize| same_installation(&self.observed[a], &self.observed[b]);
        let (groups, near) = self.groups();
        let knows = |kind: usize, p: usize| self.assemblies.knows(kind, &self.observed[p]);
        let anew = |kind: usize| (0..self.observed.len()).any(|p| !knows(kind, p));
        let there = self.there();
        let mut groups = groups.shared([0, 1].map(|k| there[k] && anew(k)), self.noise).varying(self.scatter);
        for k in (0..self.scatter.len()).filter(|k| !anew(2 + k)) {
            groups.list[groups.varying + k].mode = NONE;
        }
        let varying = |numbers: &[(usize, usize)]| -> Vec<(usize, Matrix)> {
            (groups.varying..).zip(self.scatter.iter().map(|s| s.structure(numbers, same))).collect()
        };
        let offsets = self.offsets();
        let measured = if self.noise.measured { 1.0 } else { 0.0 };
        let (mut blocks, mut order) = (Vec::new(), Vec::new());
        // Each number of a block: its point, its place among those measured there, and its row.
        let mut add = |numbers: &[(usize, usize, usize)]| {
            let n = numbers.len();
            if n == 0 {
                return;
            }
            let values = numbers.iter().map(|&(p, k, _)| self.used[p].values[k]).collect();
            let rows: Vec<(usize, usize)> = numbers.iter().map(|&(p, _, row)| (p, row)).collect();
            let mut names: Vec<&str> =
                rows.iter().map(|&(p, _)| self.observed[p].conditions.id.as_str()).collect();
            names.dedup();
            // A matrix among the numbers of one point, of which it may have only those of pressures.
            let within = |of: &dyn Fn(usize, usize, usize) -> f64| {
                Matrix::from_fn(n, n, |i, j| {
                    let ((p, a, _), (q, b, _)) = (numbers[i], numbers[j]);
                    if p == q { of(p, a, b) } else { 0.0 }
                })
            };
            let of_pressures = |of: &dyn Fn(usize) -> Option<Matrix>| {
                let each: BTreeMap<usize, Option<Matrix>> = rows.iter().map(|&(p, _)| (p, of(p))).collect();
                let row = |p: usize, k: usize| self.used[p].rows[k].checked_sub(2);
                within(&|p, a, b| match (row(p, a), row(p, b), &each[&p]) {
                    (Some(a), Some(b), Some(matrix)) => matrix[(a, b)],
                    _ => 0.0,
                })
            };
            let of = |row: usize| -> Vec<usize> { (0..n).filter(|&i| rows[i].1 == row).collect() };
            let shared = |row: usize| {
                Matrix::from_fn(n, n, |i, j| {
                    let ((a, r), (b, s)) = (rows[i], rows[j]);
                    let own = r == row && s == row && (a == b || same(a, b));
                    f64::from(u8::from(own && !knows(row, a)))
                })
            };
            let own = within(&|p, a, b| self.used[p].covariance[(a, b)]);
            let mut block = Observation::new(names.join(" "), values)
                .with_floor(errors.covariance(&rows).plus(measured, &own));
            if rows.iter().any(|(_, row)| *row < 2) {
                block = block.with_independent_noise(0, &of(0)).with_independent_noise(1, &of(1));
                let installations = groups.installation.into_iter().flatten();
                block = with(block, installations.enumerate().map(|(k, group)| (group, shared(k))));
            }
            if rows.iter().any(|(_, row)| *row >= 2) {
                let noise = of_pressures(&|p| Some(relative_noise(&self.used[p].pressures)));
                let near = groups.near_field.map(|group| (group, of_pressures(&|p| near[p].clone())));
                block = with(block.with_noise(2, noise), near);
            }
            blocks.push(with(block, varying(&rows)));
            order.extend(rows.iter().map(|(p, row)| offsets[*p] + row));
        };
        for group in errors.together(same) {
            let numbers = |wanted: &dyn Fn(usize) -> bool| -> Vec<(usize, usize, usize)> {
                let of = |&p: &usize| self.used[p].rows.iter().enumerate().map(move |(k, &row)| (p, k, row));
                group.iter().flat_map(of).filter(|(_, _, row)| wanted(*row)).collect()
            };
            if is_one_block(errors, &group, self.used, self.scatter) {
                add(&numbers(&|_| true));
                continue;
            }
            add(&numbers(&|row| row < 2));
            let pressures = numbers(&|row| row >= 2);
            pressures.chunk_by(|a, b| a.0 == b.0).for_each(&mut add);
        }
        Ok((Data::new(blocks, groups.list)?, order))
    }

    /// Where more is told of a draw of a parameter that varies than one block can hold, in a sentence.
    pub(crate) fn drawn_anew(&self, errors: &PointErrors) -> Option<String> {
        let same = |a: usize, b: usize| same_installation(&self.observed[a], &self.observed[b]);
        let apart = |group: &Vec<usize>| {
            let told = self.scatter.iter().find(|s| is_told_by_pressures(s, group, self.used))?;
            let one = is_one_block(errors, group, self.used, self.scatter);
            (!one).then(|| told.group.name.trim_end_matches(BETWEEN).to_owned())
        };
        let name = errors.together(same).iter().find_map(apart)?;
        Some(format!(
            "`{name}` varies from installation to installation, and more than {TOGETHER_WHERE_ENDS_VARY} numbers share the errors of one: the \
             pressures of each of these modes count as if `{name}` were drawn anew for them, so that its standard deviation is too small and the evidence is \
             wrong; use fewer `microphones` in this stage, or fewer points that share a day"
        ))
    }

    /// Variance of the relative pressures where microphones stand in the near field of a part, closer to it
    /// than the radius of the duct; nothing where none does.
    ///
    /// There the pressure is that of the flow through and round the part, and no plane wave's. The reference
    /// microphone's share is one that all others have. It is no part of the floor, from which the inference
    /// judges whether a floating noise is needed at all.
    fn near_field(&self, observed: &Observed, used: &Used) -> Option<Matrix> {
        let reference = self.rig.microphones.reference;
        let variance = |m: usize| near_field(self.rig, &observed.conditions, m).powi(2);
        let common = if used.others.is_empty() { 0.0 } else { variance(reference) };
        let own: Vec<f64> = used.others.iter().map(|&m| variance(m)).collect();
        if common == 0.0 && own.iter().all(|v| *v == 0.0) {
            return None;
        }
        let shared = relative_noise(&used.pressures);
        let size = 2 * own.len();
        Some(Matrix::from_fn(size, size, |i, j| {
            let diagonal = f64::from(u8::from(i == j));
            // `relative_noise` is the identity, each microphone's own noise, and the reference's, which they
            // share.
            common * (shared[(i, j)] - diagonal) + own[i / 2] * diagonal
        }))
    }
}

/// The matrix of the pressures among all measured numbers of an observation.
fn padded(used: &Used, of_pressures: &Matrix) -> Matrix {
    let n = used.rows.len();
    Matrix::from_fn(n, n, |i, j| match (used.rows[i].checked_sub(2), used.rows[j].checked_sub(2)) {
        (Some(a), Some(b)) => of_pressures[(a, b)],
        _ => 0.0,
    })
}

/// Standard deviation that the near fields of parts give a microphone; 0 away from them.
pub(crate) fn near_field(rig: &Rig, conditions: &Conditions, microphone: usize) -> f64 {
    let layout = &conditions.layout;
    let Some(&x) = layout.microphones.get(microphone) else { return 0.0 };
    let radius = (layout.areas(x)[0] / std::f64::consts::PI).sqrt();
    let felt = rig.parts.iter().zip(&layout.parts).filter_map(|(part, at)| match (part.near_field, at) {
        (Some(sd), PartAt::Places(places)) => {
            let middle = places.iter().sum::<f64>() / places.len() as f64;
            ((middle - x).abs() < radius).then_some(sd)
        }
        _ => None,
    });
    felt.fold(0.0, f64::max)
}

/// A block with the noises that act on it: the group of each, and its structure.
fn with(block: Observation, noises: impl IntoIterator<Item = (usize, Matrix)>) -> Observation {
    noises.into_iter().fold(block, |block, (group, structure)| block.with_noise(group, structure))
}
