//! Errors of the channels within the stated errors of pressures.

use crate::source::Source;
use crate::{ObservedMode, Study, StudyError, StudyProblem};
use rijke_numerics::{Matrix, symmetric_eigen};
use rijke_rig::ChannelErrors;

/// By so much of its size may a variance come out below zero by rounding.
const ROUNDING: f64 = 1e-6;

impl Study {
    /// The modes of a table, whose stated errors contain those of the channels: added where
    /// `channels.toml` says that they do not, seen to where a stage is to take them out.
    ///
    /// # Errors
    /// File, line and remedy.
    pub(crate) fn with_channels(
        &self,
        source: &Source,
        modes: Vec<(usize, ObservedMode)>,
    ) -> Result<Vec<ObservedMode>, StudyError> {
        let Some(channels) = self.channels()? else { return Ok(modes.into_iter().map(|m| m.1).collect()) };
        let taken = self.plan.stages.iter().any(|s| s.channels);
        let whole = |(line, mut mode): (usize, ObservedMode)| {
            let Some(share) = self.share(&channels, &mode) else { return Ok(mode) };
            if !channels.contained {
                mode.covariance = mode.covariance.plus(1.0, &share);
            } else if let Some(what) = taken.then(|| self.beyond(&mode, &share)).flatten() {
                let of = self.campaign.points[mode.point].id.clone();
                return Err(source.at_line(line, StudyProblem::ChannelsAlone { of, what }));
            }
            Ok(mode)
        };
        modes.into_iter().map(whole).collect()
    }

    /// What the errors of the channels make of the numbers of a mode: a pressure P is measured as P (1 - s d
    /// + g). None of a mode whose frequency was not measured.
    fn share(&self, errors: &ChannelErrors, mode: &ObservedMode) -> Option<Matrix> {
        let (reference, s) = (self.rig.microphones.reference, mode.near(0.0)?);
        let (rows, n) = (mode.numbers().len(), errors.delays.rows());
        let first = rows - 2 * mode.pressures.len();
        let mut slopes = Matrix::zeros(rows, 2 * n);
        for (k, (m, p)) in mode.pressures.iter().enumerate().filter(|(_, (m, _))| *m != reference) {
            let (row, m) = (first + 2 * k, m - usize::from(*m > reference));
            for (column, z) in [(m, -*p * s), (n + m, *p)] {
                (slopes[(row, column)], slopes[(row + 1, column)]) = (z.re, z.im);
            }
        }
        let covariance = Matrix::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
            (true, true) => errors.delays[(i, j)],
            (false, false) => errors.gains[(i - n, j - n)],
            _ => 0.0,
        });
        Some(slopes.product(&covariance).product(&slopes.transpose()))
    }

    /// Where the errors of the channels are larger than the stated ones, in words.
    fn beyond(&self, mode: &ObservedMode, share: &Matrix) -> Option<String> {
        let stated = &mode.covariance;
        let n = stated.rows();
        let first = n - 2 * mode.pressures.len();
        let size = |i: usize| stated[(i, i)].sqrt();
        let rest = Matrix::from_fn(n, n, |i, j| (stated[(i, j)] - share[(i, j)]) / (size(i) * size(j)));
        let worst = (first..n).min_by(|i, j| rest[(*i, *i)].total_cmp(&rest[(*j, *j)]))?;
        if rest[(worst, worst)] < -ROUNDING {
            let name = &self.rig.microphones.names[mode.pressures[(worst - first) / 2].0];
            let part = ["re", "im"][(worst - first) % 2];
            let (here, by_channels) = (size(worst), share[(worst, worst)].sqrt());
            return Some(format!("{name}_{part}: sd {here:.2e} here, {by_channels:.2e} by the channels"));
        }
        let least = symmetric_eigen(&rest).ok()?.0.first().copied()?;
        (least < -ROUNDING).then(|| "of all of them together, not of one by itself".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::OneTable;
    use std::path::{Path, PathBuf};

    const RIG: &str = "name = \"tube\"\n[upstream]\ntype = \"closed\"\n[downstream]\ntype = \"open\"\n\
        [[element]]\ntype = \"duct\"\nlength = \"L0\"\ndiameter = 0.05\n[microphones]\nat = [0.1, 0.3, 0.5]\n";
    const CHANNELS: &str =
        "delay_covariance_s2 = [[4e-10, 0], [0, 4e-10]]\ngain_covariance = [[4e-4, 2e-4], [2e-4, 4e-4]]\n";

    /// A folder that is removed when the test ends.
    struct Scratch(PathBuf);

    impl Drop for Scratch {
        fn drop(&mut self) {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }

    /// What is read of one row, whose columns behind the frequency are `more`.
    fn read(name: &str, more: &[(&str, &str)], channels: Option<&str>) -> Result<ObservedMode, String> {
        let folder = std::env::temp_dir().join(format!("rijke-contained-{}-{name}", std::process::id()));
        let scratch = Scratch(folder);
        let folder: &Path = &scratch.0;
        std::fs::create_dir_all(folder.join("observations")).unwrap();
        let [names, cells] = [|c: &(&str, &str)| c.0.to_owned(), |c: &(&str, &str)| c.1.to_owned()]
            .map(|part| more.iter().map(part).collect::<Vec<_>>().join(","));
        let table = format!("L0,growth_rate,frequency [Hz],{names}\n0.8,-3,107,{cells}\n");
        std::fs::write(folder.join("rig.toml"), RIG).unwrap();
        std::fs::write(folder.join("modes.csv"), table).unwrap();
        if let Some(text) = channels {
            std::fs::write(folder.join("observations/channels.toml"), text).unwrap();
        }
        let table = OneTable::read(&folder.join("rig.toml"), &folder.join("modes.csv")).unwrap();
        let (mut study, observations) = table.study().map_err(|error| error.to_string())?;
        study.folder = folder.to_owned();
        study.plan.stages[0].channels = true;
        let source = Source::read(&folder.join("modes.csv")).unwrap();
        let mode = (2, observations.modes.into_iter().next().unwrap());
        let mut modes = study.with_channels(&source, vec![mode]).map_err(|error| error.to_string())?;
        Ok(modes.remove(0))
    }

    const VALUES: [(&str, &str); 6] = [
        ("growth_rate_sd", "0.5"),
        ("frequency_sd", "2"),
        ("p2_re", "0.8"),
        ("p2_im", "0.1"),
        ("p3_re", "0.4"),
        ("p3_im", "-0.1"),
    ];

    fn with(more: &[(&'static str, &'static str)]) -> Vec<(&'static str, &'static str)> {
        VALUES.iter().chain(more).copied().collect()
    }

    const SDS: [(&str, &str); 4] =
        [("p2_re_sd", "0.003"), ("p2_im_sd", "0.003"), ("p3_re_sd", "0.003"), ("p3_im_sd", "0.003")];

    #[test]
    fn exact_deviations_stand_beside_covariances_in_the_units_of_their_columns() {
        let plain = read("plain", &with(&SDS), None).unwrap().covariance;
        let hertz = 2.0 * std::f64::consts::PI;
        for (i, sd) in [0.5, 2.0 * hertz, 0.003, 0.003, 0.003, 0.003].into_iter().enumerate() {
            assert!((plain[(i, i)] - sd * sd).abs() < 1e-12 * sd * sd, "{plain:?}");
        }
        let mut more = with(&SDS);
        more.push(("cov_p3_re_p2_re", "1e-6"));
        more.push(("cov_growth_rate_frequency", "0.3"));
        let both = read("both", &more, None).unwrap().covariance;
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12 * b.abs(), "{a} {b}");
        (0..6).for_each(|i| close(both[(i, i)], plain[(i, i)]));
        close(both[(2, 4)], 1e-6);
        close(both[(4, 2)], 1e-6);
        close(both[(0, 1)], 0.3 * hertz);
        // A variance in place of a deviation: in Hz^2, as the column is.
        let mut more = with(&SDS);
        more[1] = ("cov_frequency_frequency", "4");
        close(read("variance", &more, None).unwrap().covariance[(1, 1)], plain[(1, 1)]);
        // A unit of its own counts.
        for (heading, cell, expected) in [
            ("cov_frequency_frequency [Hz^2]", "4", 4.0 * hertz * hertz),
            ("cov_frequency_frequency [rad^2/s^2]", "4", 4.0),
            ("cov_frequency_frequency [1/s^2]", "4", 4.0),
        ] {
            more[1] = (heading, cell);
            close(read("unit", &more, None).unwrap().covariance[(1, 1)], expected);
        }
        more[1] = ("frequency_sd", "2");
        more.push(("cov_growth_rate_frequency [Hz/s]", "0.3"));
        close(read("mixed", &more, None).unwrap().covariance[(0, 1)], 0.3 * hertz);
    }

    #[test]
    fn exact_errors_that_contradict_one_another_are_refused() {
        let refused = |name: &str, extra: (&'static str, &'static str), says: &[&str]| {
            let mut more = with(&SDS);
            more.push(extra);
            let error = read(name, &more, None).unwrap_err();
            says.iter().for_each(|part| assert!(error.contains(part), "{error}"));
        };
        refused(
            "two",
            ("cov_p2_re_p2_re", "9e-6"),
            &["modes.csv, line 2", "`p2_re_sd` and `cov_p2_re_p2_re` both state", "keep one"],
        );
        refused(
            "other",
            ("cov_angular_frequency_p2_re", "1e-6"),
            &["line 1", "speaks of `angular_frequency`, which no column is called"],
        );
        refused("unit", ("cov_frequency_p2_re [s]", "4"), &["line 1", "`s` is not a unit of this quantity"]);
        let error = read("lacks", &with(&SDS[..3]), None).unwrap_err();
        assert!(error.contains("line 2") && error.contains("`p3_im_sd` is missing"), "{error}");
    }

    #[test]
    fn exact_errors_of_channels_are_contained_or_added() {
        let error = read("smaller", &with(&SDS), Some(CHANNELS)).unwrap_err();
        for part in
            ["modes.csv, line 2", "of line-2 are smaller", "p2_re: sd 3.00e-3 here", "`contained = false`"]
        {
            assert!(error.contains(part), "{error}");
        }
        let plain = read("without", &with(&SDS), None).unwrap();
        let added = read("added", &with(&SDS), Some(&format!("{CHANNELS}contained = false\n"))).unwrap();
        // P (1 - s d + g), by hand, of the real parts of the two pressures.
        let s = plain.near(0.0).unwrap();
        let (p, q) = (plain.pressures[0].1, plain.pressures[1].1);
        let own = 4e-10 * (p * s).re.powi(2) + 4e-4 * p.re.powi(2) + 9e-6;
        let shared = 2e-4 * p.re * q.re;
        for ((i, j), expected) in [((2, 2), own), ((2, 4), shared), ((0, 0), 0.25)] {
            let found = added.covariance[(i, j)];
            assert!((found - expected).abs() < 1e-12 * expected.abs(), "{i} {j}: {found} {expected}");
        }
        // As large by themselves, but without what they share: refused with that in words.
        let large: Vec<String> =
            (2..6).map(|i| (1.05 * added.covariance[(i, i)]).sqrt().to_string()).collect();
        let mut more = with(&[]);
        for ((name, _), sd) in SDS.iter().zip(&large) {
            more.push((name, Box::leak(sd.clone().into_boxed_str())));
        }
        let error = read("apart", &more, Some(CHANNELS)).unwrap_err();
        assert!(error.contains("of all of them together"), "{error}");
    }
}
