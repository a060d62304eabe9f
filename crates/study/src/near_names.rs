//! Names of factors that are nearly those of columns with a meaning of their own.

use crate::Campaign;
use crate::campaign::RESERVED;

impl Campaign {
    /// Factors whose names are a letter away from a column with a meaning of its own.
    pub(crate) fn nearly_reserved(&self) -> Vec<String> {
        let near = |name: &str| RESERVED.iter().find(|known| is_near(name, known));
        let said = |(name, known): (&str, &str)| {
            format!(
                "{}: the column `{name}` is a factor, and its name is nearly `{known}`, a column with a meaning of its own: correct the \
                 name, or call the factor otherwise",
                self.file
            )
        };
        self.factors.iter().filter_map(|f| Some(said((&f.name, near(&f.name)?)))).collect()
    }
}

/// Whether a name is a reserved one with other capitals, or with a slip: a letter too many, too few or
/// another, or two that changed places. Of three letters only one too many counts: `dry` is no `day`.
fn is_near(name: &str, reserved: &str) -> bool {
    let [a, b] = [name, reserved].map(|s| s.to_lowercase().chars().collect::<Vec<char>>());
    if a == b {
        return name != reserved;
    }
    if b.len() <= 3 {
        return a.len() == b.len() + 1 && a.starts_with(&b);
    }
    let same = a.iter().zip(&b).take_while(|(x, y)| x == y).count();
    let (rest, other) = (&a[same..], &b[same..]);
    let tail = |x: usize, y: usize| rest.get(x..).is_some() && rest.get(x..) == other.get(y..);
    let exchanged = rest.len() >= 2 && other.len() >= 2 && rest[0] == other[1] && rest[1] == other[0];
    tail(1, 0) || tail(0, 1) || tail(1, 1) || (exchanged && tail(2, 2))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may fail by panicking")]
mod tests {
    use super::is_near;

    #[test]
    fn exact_slips_of_reserved_names_are_found() {
        for (name, known) in [
            ("T_abm", "T_amb"),
            ("T_am", "T_amb"),
            ("t_amb", "T_amb"),
            ("days", "day"),
            ("repeat", "repeats"),
            ("T_ambsd", "T_amb_sd"),
        ] {
            assert!(is_near(name, known), "{name}");
        }
        for (name, known) in [
            ("dry", "day"),
            ("T_hot", "T_amb"),
            ("T_amb", "T_amb"),
            ("flow", "row"),
            ("rod", "row"),
            ("x_g", "day"),
        ] {
            assert!(!is_near(name, known), "{name}");
        }
    }

    #[test]
    fn message_of_slips_names_what_was_meant() {
        let folder = std::env::temp_dir().join(format!("rijke-doubtful-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("candidates")).unwrap();
        let write = |file: &str, text: &str| std::fs::write(folder.join(file), text).unwrap();
        let rig = |diameter: &str, at: &str| {
            format!(
                "name = \"Slips\"\n[gas]\ntemperature = 293.15\npressure = 101325\n[upstream]\ntype = \"closed\"\n[downstream]\ntype = \"free\"\n\
                 [[element]]\nname = \"tube\"\ntype = \"duct\"\nlength = 0.8\ndiameter = {diameter}\nwall = \"none\"\n\
                 [microphones]\nat = {at}\nnames = [\"p1\", \"p2\"]\n"
            )
        };
        write(
            "candidates/all.toml",
            "[[candidate]]\nid = \"end\"\nrole = \"end\"\nname = \"end\"\ncite = [\"a test\"]\n[[candidate.effect]]\nacts_at = \"downstream\"\n\
             reflection = \"-1\"\n",
        );
        write("rig.toml", &rig("0.05", "[0.1, 0.5]"));
        write(
            "campaign.csv",
            "point,row,Q [W],T_amb [K]\na,cold,0,293\nb,hot,50,293\nc,hot,,293\nd,hot,-,293\n",
        );
        write(
            "study.toml",
            "name = \"slips\"\nbase = \"rig\"\n[[stage]]\nid = \"cold\"\npoints = { where = { Q = 0 } }\ncompete = [\"end\"]\n\
             [[stage]]\nid = \"hot\"\npoints = { where = { Q = { above = 0 } } }\ncompete = [\"end\"]\n",
        );
        let said = || crate::Study::open(&folder).unwrap().doubtful();
        let lost = said();
        assert!(lost.len() == 1 && lost[0].contains("no stage takes c, d, because `Q`"), "{lost:?}");
        write("campaign.csv", "point,row,Q [W],T_abm [K]\na,cold,0,293\nb,hot,50,293\n");
        let near = said();
        assert!(near.len() == 1 && near[0].contains("`T_abm`") && near[0].contains("`T_amb`"), "{near:?}");
        write("campaign.csv", "point,row,Q [W],T_amb [degC]\na,cold,0,293.15\nb,hot,50,294\n");
        let hot = said();
        assert!(hot.len() == 1 && hot[0].contains("T_amb is 293.1 degC at a, b: 293.1 K is"), "{hot:?}");
        write("campaign.csv", "point,row,Q [W],T_amb [degC]\na,cold,0,20\nb,hot,50,180\n");
        assert_eq!(said(), Vec::<String>::new());
        write("campaign.csv", "point,row,Q [W]\na,cold,0\nb,hot,50\n");
        assert_eq!(said(), Vec::<String>::new());
        write("campaign.csv", "point,row,Q [W],T2 [K]\na,cold,0,20\nb,hot,50,180\n");
        write("rig.toml", &rig("0.05\ntemperature = \"T2\"", "[0.1, 0.5]"));
        let cold = said();
        assert!(cold.len() == 1 && cold[0].contains("temperature of `tube` is 20.0 K at a, b"), "{cold:?}");
        write("campaign.csv", "point,row,Q [W],T2 [degC]\na,cold,0,20\nb,hot,50,180\n");
        assert_eq!(said(), Vec::<String>::new());
        write("campaign.csv", "point,row,Q [W],T2 [degC]\na,cold,0,0\nb,hot,50,180\n");
        let difference = said();
        assert!(
            difference.len() == 1 && difference[0].contains("`T2` is 0 degC, which is 273.15 K, at a"),
            "{difference:?}"
        );
        write("campaign.csv", "point,row,Q [W]\na,cold,0\nb,hot,50\n");
        write("rig.toml", &rig("44", "[0.1, 0.103]"));
        let sizes = said();
        assert!(sizes.len() == 2 && sizes[0].contains("`p1` and `p2` are 3.0 mm apart"), "{sizes:?}");
        assert!(sizes[1].contains("44.0000 m wide"), "{sizes:?}");
        // Metres where millimetres are meant, and a pipeline.
        let long = |length: &str, hertz: &str| {
            let rig = rig("0.3", "[0.1, 0.5]").replace("length = 0.8", &format!("length = {length}"));
            write("rig.toml", &format!("{rig}[search]\nfrequency_hz = [1, {hertz}]\n"));
            said()
        };
        let millimetres = long("800", "300");
        assert!(millimetres.len() == 1 && millimetres[0].contains("800.0000 m long"), "{millimetres:?}");
        assert_eq!(long("150", "60"), Vec::<String>::new());
        // A resonator and a screen do not stand in a row; two resonators need no order, nor do laws of
        // candidates at parts that have none.
        let devices = |first: &str, second: &str, x: f64| {
            let resonator = "type = \"helmholtz\"\nvolume = 1e-4\nneck_area = 1e-5\nneck_length = 0.01";
            let list = [("one", first, 0.3), ("two", second, x)].map(|(name, kind, x)| {
                let kind = kind.replace("RESONATOR", resonator);
                format!("[[element]]\nname = \"{name}\"\nat = {x}\n{kind}\n")
            });
            write("rig.toml", &(rig("0.05", "[0.1, 0.5]") + &list.concat()));
            said()
        };
        let [plain, screen] = ["type = \"device\"", "type = \"screen\"\nresistance = 10"];
        let row = devices("RESONATOR", screen, 0.3);
        assert!(
            row.len() == 1 && row[0].contains("`one` and `two` are at one place at a, b: both"),
            "{row:?}"
        );
        assert_eq!(devices("RESONATOR", screen, 0.300001), Vec::<String>::new());
        assert_eq!(devices("RESONATOR", "RESONATOR", 0.3), Vec::<String>::new());
        assert_eq!(devices(plain, screen, 0.3), Vec::<String>::new());
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn message_of_rows_that_were_copied() {
        let campaign = |text: &str| {
            crate::Campaign::parse(&crate::source::Source { file: "campaign.csv".into(), text: text.into() })
        };
        let campaign = campaign("point,x [m]\na,1\nb,2\nc,1\n").unwrap();
        let mode = |point: usize, growth: Option<f64>| crate::ObservedMode {
            point,
            label: String::new(),
            growth_rate: growth,
            angular_frequency: Some(600.0),
            pressures: Vec::new(),
            covariance: rijke_numerics::Matrix::zeros(2, 2),
            drift_sd: 0.0,
        };
        let said = |modes: &[crate::ObservedMode]| {
            let ambient = std::collections::BTreeMap::new();
            let (kind, source) = (rijke_rig::DataKind::Measured, String::new());
            crate::ObservedModes { kind, source, modes: modes.to_vec(), ambient }.copied(&campaign)
        };
        // The same two numbers at another length may be chance; at the same length they are a copy.
        assert_eq!(said(&[mode(0, Some(-3.0)), mode(1, Some(-3.0)), mode(2, Some(-3.5))]), None);
        let copied = said(&[mode(0, Some(-3.0)), mode(1, Some(-3.5)), mode(2, Some(-3.0))]).unwrap();
        assert!(copied.starts_with("c has the same numbers as a to the last digit:"), "{copied}");
    }
}
