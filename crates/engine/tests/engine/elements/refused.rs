//! Elements that are refused.

use super::{CLOSED, LOSSY, assembly, conditions, network, study};
use rijke_engine::PointModel;

/// Bad input: what is said, with file and line.
#[test]
fn behaviour_bad_elements_are_refused_with_line_and_remedy() {
    let flame = |keys: &str| network(&format!("[[element]]\ntype = 'flame'\n{keys}\n"), [CLOSED, LOSSY]);
    let end = |keys: &str| network("", [CLOSED, keys]);
    let element = |keys: &str| network(&format!("[[element]]\n{keys}\n"), [CLOSED, LOSSY]);
    for (text, line, said) in [
        (flame("gain = 1\ntable = [[100, 1, 0], [200, 1]]"), 20, "[frequency in Hz, gain, phase in rad]"),
        (flame("gain = 1\ntable = [[100, 1, 0], [200, 1, 0]]"), 20, "at least 3 rows"),
        (flame("gain = 1\ntable = [[100, 1, 0], [90, 1, 0], [300, 1, 1]]"), 20, "row 2"),
        (flame("gain = 1\ntable = TABLE\ntolerance = 2"), 20, "at most 0.5"),
        (flame("gain = 1\ntable = TABLE\ncutoff_hz = 20"), 20, "give one of the two"),
        (flame("gain = 1\ntolerance = 0.1"), 20, "a tolerance is that of a table"),
        (flame("gain = 1\ntable = 'nowhere.csv'"), 20, "nowhere.csv"),
        (flame("gain = 1\ndelay = -1e-3"), 20, "zero or more"),
        (flame("gain = 1\nnumerator = [0, 0]"), 20, "not all zero"),
        (flame("gain = 1\nnumerator = [1]\ndenominator = [1, -1e-3]"), 20, "turn the sign of a coefficient"),
        (flame("gain = 1\nreference = -0.1"), 20, "a distance"),
        (flame("gain = 1\nreference_side = 'left'"), 20, "upstream, downstream"),
        (flame("gain = 1\ntabel = TABLE"), 20, "table, tolerance"),
        (
            element("type = 'orifice'\ndiameter = 0.01\nthickness = 0.001\nporosity = 1.2"),
            20,
            "above 0 and at most 1",
        ),
        (element("type = 'duct'\nlength = 0.1\ndiameter = 0.03\ngamma = 0.9"), 20, "above 1"),
        (element("type = 'duct'\nlength = 0.1\ndiameter = 0.03\ngas_constant = -287"), 20, "positive"),
        (flame("gain = 1\nlength = -0.1"), 20, "positive"),
        (flame("gain = 1\nlength = '$nothing'"), 20, "$nothing"),
        (flame("gain = 1\ndelay_end = 1e-3"), 20, "how far the flame reaches"),
        (flame("gain = 1\nlength = 0.1\npieces = 0"), 20, "1 to 1000"),
        (flame("gain = 1\nlength = 0.1\ndelay_end = -1"), 20, "zero or more"),
        (flame("gain = 1\nlength = 0.1\ndensity = [1, -1]"), 20, "zero or more and not all zero"),
        (flame("gain = 1\nlength = 0.1\ndensity = [0, 0]"), 20, "zero or more and not all zero"),
        (
            flame("gain = 1\nlength = 0.1\nreference = 0.1\nreference_side = 'downstream'"),
            20,
            "a velocity upstream",
        ),
        (element("type = 'orifice'\ndiameter = -0.01\nthickness = 0.001"), 20, "positive"),
        (element("type = 'feedback'\neu = { gian = 1 }"), 20, "gain, delay, cutoff_hz"),
        (element("type = 'feedback'\neu = { delay = -1 }"), 20, "zero or more"),
        (element("type = 'side-hole'\ndiameter = 0.01\nlength = 0.01\nwall = 'glue'"), 20, "kirchhoff"),
        (end("type = 'choked'\nmach = 0.4"), 7, "below 0.3"),
        (end("type = 'constant'\nmodulus = 0.9\nangle = 170"), 7, "in rad"),
        (end("type = 'rational'\nnumerator = [1]"), 7, "`denominator` is missing"),
        (end("type = 'table'"), 7, "`table` is missing"),
        (end("type = 'table'\ntable = TABLE\ncutoff_hz = 3"), 7, "gain, delay, table, tolerance"),
        (end("type = 'impedance'"), 7, "numerator and denominator, or table"),
        (end("type = 'unflanged'\ncalibration = [1]"), 7, "[modulus, angle in rad]"),
    ] {
        let error = study("bad", &text).map(|_| ()).unwrap_err();
        assert!(error.contains("rig.toml, line ") && error.contains(said), "{text}\n{error}");
        assert!(error.contains(&format!("line {line}:")), "line {line}: {error}");
    }
    // What only the operating point shows.
    for (text, said) in [
        (flame("gain = 1\nreference = 0.7"), "smaller distance"),
        (flame("gain = 1\nlength = 2"), "ends on the ducts"),
        // The ducts end 0.55 m behind the flame.
        (flame("gain = 1\nlength = 0.5501"), "ends on the ducts"),
        (flame("gain = 1\nlength = 0.1\npieces = 1\ndensity = [1, 0, 1]"), "give more pieces"),
        (
            flame("gain = 1\nlength = 0.2\n[[element]]\ntype = 'screen'\nresistance = 3\nat = 0.6"),
            "inside the flame",
        ),
        (
            element(
                "type = 'screen'\nresistance = 3\nat = 0.4\n[[element]]\ntype = 'flame'\ngain = 1\nreference = 0.3\nat = 0.52",
            ),
            "something acts between",
        ),
        (
            element(
                "type = 'screen'\nresistance = 3\n[[element]]\ntype = 'flame'\ngain = 1\nreference_side = 'downstream'",
            ),
            "stand alone",
        ),
    ] {
        let study = study("point", &text).unwrap();
        let (assembly, conditions) = (assembly(&study), conditions(&study));
        let error = PointModel::new(&assembly, &conditions, &[]).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
}
