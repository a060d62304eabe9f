//! A rig whose modes have a closed form.

/// The sound speed in it, m/s.
pub(crate) fn speed() -> f64 {
    (1.4_f64 * 287.05 * 293.15).sqrt()
}

/// A tube of length x without losses whose ends reflect -r: s = c (ln r + i pi) / L.
pub(crate) const TUBE: &str = r#"
name = "tube"
[gas]
temperature = "20 degC"
[upstream]
type = "constant"
modulus = "$r"
angle = "180 deg"
[downstream]
type = "constant"
modulus = "$r"
angle = "180 deg"
[[element]]
name = "tube"
type = "duct"
length = "x"
diameter = "50 mm"
[unknown.r]
prior = { normal = { mean = 0.9, sd = 0.2 } }
"#;
