//! Errors that the campaign states in which answers bend.

use super::stated::{TEMPERATURE, What, Written, number};

/// The temperature and the place of the far end, which an unknown moves by 20 mm, make up for each other
/// along a curve: over the standard deviation of the temperature answers turn by 0.15 rad, fifteen times the
/// noise.
#[test]
fn oracle_an_error_in_which_answers_bend_has_the_deviations_of_an_unknown() {
    let off = "[unknown.off]\nunit = \"m\"\nprior = { normal = { mean = 0.0, sd = 20e-3 } }\n";
    let hot = "[unknown.hot]\nunit = \"K\"\nprior = { normal = { mean = 293.15, sd = 4.0 } }\n";
    let both = format!("{off}{hot}");
    for (what, more) in [(What::Reflection, 0.0), (What::Transfer, 0.0), (What::Transfer, 0.3)] {
        let sds = [more, 0.0, 4.0];
        let rig = ["0.3 - face - $off", "", off];
        let stated = Written { sds, rig, ..Written::default() }.found("curve", what, [0.0, 0.0, -3.5]);
        let rig = ["0.3 - face - $off", "temperature = \"$hot\"", &both];
        let sds = [more, 0.0, 0.0];
        let own =
            Written { sds, rig, base: "rig", ..Written::default() }.found("own", what, [0.0, 0.0, -3.5]);
        for (error, unknown, [mean, sd]) in [
            ("sig", "sig", [0.0, 1.0]),
            ("off", "off", [0.0, 1.0]),
            ("error of T_amb (day 1)", "hot", [TEMPERATURE, 4.0]),
        ] {
            let [e, u] = [number(&stated.0, error), number(&own.0, unknown)];
            let near = (mean + sd * e[0] - u[0]).abs() < 0.02 * u[1] && (sd * e[1] / u[1] - 1.0).abs() < 0.02;
            assert!(near, "{what:?} {more} {error}: {e:?} {u:?}");
        }
        let apart = stated.0.ln_evidence() - own.0.ln_evidence();
        assert!(apart.abs() < 0.05, "{what:?}: {apart} nats");
    }
}

/// The face of a sample whose place an unknown makes up for: 32 mm are a radian, to and fro.
#[test]
fn message_an_error_in_which_answers_bend_is_told() {
    let unknown = "[unknown.off]\nunit = \"m\"\nprior = { normal = { mean = 0.0, sd = 45e-3 } }\n";
    let said = |sd: f64| {
        let rig = ["0.3 - face - $off", "", unknown];
        let written = Written { sds: [0.0, sd, 0.0], rig, ..Written::default() };
        written.found("bent", What::Reflection, [0.0; 3]).0.remark.unwrap_or_default()
    };
    let remark = said(45.0);
    assert!(remark.contains("error of face 0.025 (i): over its"), "said: {remark}");
    assert!(remark.contains("an unknown of the rig, and write `checked = true`"), "{remark}");
    assert!(!said(0.3).contains("bend"), "{}", said(0.3));
}
