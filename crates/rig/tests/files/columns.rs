//! Tables of numbers by the names of their columns: text, MATLAB, HDF5; and what is said of bad ones.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use rijke_rig::Columns;
use std::path::Path;

fn parse(text: &str) -> Columns {
    Columns::parse(text, Path::new("z.csv")).unwrap()
}

#[test]
fn exact_an_impedance_is_read_as_it_was_written() {
    let texts = [
        "frequency [Hz],real,imag,who\n100,0.5,-1.25,A\n200,0.25,-0.5,B\n",
        "# impedance of the plate\nfrequency [kHz];real;imag;who\n\n0,1;0,5;-1,25;A\n% second day\n0,2;0,25;-0,5;B\n",
        "frequency [Hz]\treal\timag\twho\r\n1e2\t5e-1\t-1.25\tA\r\n2e2\t0.25\t-5e-1\tB\r\n",
        "imag real who frequency\n-1.25 0.5 A 100\n-0.5 0.25 B 200",
    ];
    for text in texts {
        let table = parse(text);
        assert_eq!(table.keys("frequency", "Hz").unwrap(), [100.0, 200.0], "{text}");
        assert_eq!(
            (table.numbers("real", "1").unwrap(), table.numbers("imag", "1").unwrap()),
            (vec![0.5, 0.25], vec![-1.25, -0.5])
        );
        assert_eq!((table.words("who").unwrap(), table.len()), (vec!["A", "B"], 2));
    }
    let table = parse(texts[0]);
    let omega = table.numbers("frequency", "rad/s").unwrap();
    assert!((omega[1] - 400.0 * std::f64::consts::PI).abs() < 1e-10);
    assert!(table.has("real") && !table.has("phase") && !table.is_empty());
}

#[test]
fn exact_an_empty_cell_is_no_number() {
    let table = parse("x [mm],T [degC]\n10,20\n20,\n30,-273.15\n");
    let said = table.numbers("T", "K").unwrap_err().to_string();
    assert_eq!(said, "z.csv: line 3, column `T`: `` is not a finite number");
}

#[test]
fn exact_arrays_by_name() {
    let fixture =
        |name: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/records").join(name);
    let text = Columns::read(&fixture("text.csv")).unwrap();
    let packed = Columns::read(&fixture("packed.h5")).unwrap();
    let plain = Columns::read(&fixture("v5.mat")).unwrap();
    for (named, other) in [("left", "p[0]"), ("right", "p[1]")] {
        let samples = text.numbers(named, "Pa").unwrap();
        assert_eq!(
            (packed.numbers(named, "Pa").unwrap(), plain.numbers(other, "Pa").unwrap()),
            (samples.clone(), samples)
        );
    }
    assert_eq!(plain.numbers("fs", "Hz").unwrap(), [1e4]);
    let said = plain.numbers("q", "Pa").unwrap_err().to_string();
    assert!(said.contains("v5.mat: header: there is no column `q`; the file has `p[0]`, `p[1]`"), "{said}");
}

/// What spreadsheets leave: empty columns at the end, empty rows, and a decimal comma.
#[test]
fn exact_tables_of_spreadsheets_are_those_of_their_numbers() {
    let plain = parse("f,z,case\n100,0.5,a\n200,-0.25,b\n");
    for text in [
        "f,z,case,,\n100,0.5,a,,\n,,,,\n200,-0.25,b,,\n,,,,\n",
        "f;z;case;;\n100;0,5;a;;\n200;-0,25;b;;\n;;;;\n",
        "f\tz\tcase\t\t\n100\t0,5\ta\n200\t-0,25\tb\t\t\n",
    ] {
        let table = parse(text);
        assert_eq!(table.headings(), plain.headings(), "{text:?}");
        assert_eq!(table.numbers("f", "Hz").unwrap(), [100.0, 200.0]);
        let complex = table.complex("z").unwrap();
        assert_eq!(complex, plain.complex("z").unwrap(), "{text:?}");
        assert_eq!(table.words("case").unwrap(), ["a", "b"]);
    }
}

#[test]
fn message_of_bad_tables() {
    let whole =
        |text: &str| Columns::parse(text, Path::new("z.csv")).map(|t| t.len()).unwrap_err().to_string();
    let key = |text: &str| parse(text).keys("f", "Hz").unwrap_err().to_string();
    for (said, part) in [
        (whole(""), "z.csv: line 1: is empty; give at least a line of names and a row"),
        (whole("# nothing\nf,g\n"), "z.csv: line 2: is empty; give at least one row below the names"),
        (whole("1,2\n3,4\n"), "z.csv: line 1: `1,2` is not a line of names"),
        (whole("f,g\n1,2\n\n3\n"), "z.csv: line 4: 1 columns, the rows before have 2"),
        (
            whole("f,g,,\n1,2,,\n3,4,,5\n"),
            "z.csv: line 3, column 4: `5` is not empty, but it stands behind the last heading",
        ),
        (key("f,g\n1,2\n3,2\n1,2\n"), "z.csv: line 4, column `f`: `1` stands in line 2 already; keep one"),
        (key("f,g\n1,2\n3,2\n# day two\n2,2\n"), "z.csv: line 5, column `f`: 2 follows 3; sort the rows"),
        (key("f,g\n1,2\nx,2\n"), "z.csv: line 3, column `f`: `x` is not a finite number"),
        (key("f,g\n1,2\ninf,2\n"), "z.csv: line 3, column `f`: `inf` is not a finite number"),
        (key("f [mm],g\n1,2\n"), "z.csv: column `f`: `mm` is not a unit of this quantity, which is in Hz"),
        (key("f,f\n1,2\n"), "z.csv: header: `f` appears twice"),
        (key("g,h\n1,2\n"), "z.csv: header: there is no column `f`; the file has `g`, `h`; correct the name"),
    ] {
        assert!(said.contains(part), "no `{part}` in: {said}");
    }
}
