//! The bench of the laboratory against networks of the same physics: two programs that share no acoustic
//! code.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use rijke_lab::bench::Bench;
use rijke_numerics::C64;
use std::f64::consts::TAU;
use std::fmt::Write as _;

/// A perfect gas with the numbers that network files have by default, at 293.15 K.
const GAS: &str = "
[gas]
molar_mass = 0.028965206821111304 # 8.314462618/287.05
heat_capacity = [29.100619163, 0.0, 0.0, 0.0] # 7/2 of it
viscosity = [1.715695168042807e-5, 110.4] # 1.813e-5 Pa s at 293.15 K
conductivity = [0.024062367983189573, 194.0] # Pr = 0.71 there
";

/// The modes of a truth at its only point, by the bench.
fn by_bench(truth: &str, campaign: &str) -> Vec<C64> {
    let folder = std::env::temp_dir().join(format!("rijke-bench-{}-{:p}", std::process::id(), truth));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("truth.toml"), truth).unwrap();
    std::fs::write(folder.join("campaign.csv"), campaign).unwrap();
    let seen = Bench::read(&folder.join("truth.toml")).unwrap().observe(1).unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    seen.modes.iter().map(|mode| mode.exact).collect()
}

/// The modes of a network file.
fn by_network(text: &str) -> Vec<C64> {
    let built = rijke_network::file::read(text).unwrap();
    let modes = built.modes(&built.region).unwrap();
    let mut all: Vec<C64> = modes.modes.iter().map(|mode| mode.s).collect();
    all.sort_by(|a, b| a.im.total_cmp(&b.im));
    all
}

/// The bench's files that every case shares; `parts` follow.
fn truth(parts: &str, gas: &str) -> String {
    format!(
        "name = \"case\"\ncampaign = \"campaign.csv\"\nadded_mass = false\nvolume_flow = \"flow\"\n{parts}\n{gas}
[search]\ngrowth_rate = [-250.0, -0.5]\nfrequency_hz = [40.0, 900.0]
[microphones]\nat = [0.1]\nreference = 1
[noise]\ngrowth_rate = 0.1\nfrequency_hz = 0.1\npressure = 0.01\n"
    )
}

const SEARCH: &str = "[search]\ngrowth_rate = [-250, -0.5]\nfrequency_hz = [40, 900]\n";

#[test]
fn oracle_chain_at_rest_against_the_network() {
    // Ducts with Bessel layers, changes of area, a flame with gain and delay, a screen with mass, a closed
    // side branch. The bench's flame needs a flow: 1e-8 m^3/s carries 1.2e-11 W, which warms the gas by 1e-6
    // K.
    let gain = 0.3 * 1.0e-8 / (0.4 / 1.4 / 101_325.0) / 1.2e-11;
    let bench = truth(
        &format!(
            "upstream = {{ type = \"reflection\", modulus = 0.99, angle = 0.0 }}
downstream = {{ type = \"reflection\", modulus = 0.97, angle = 3.0 }}
[[duct]]\nlength = 0.25\ndiameter = 0.1\nlayers = 1.0
[[duct]]\nlength = 0.12\ndiameter = 0.032\nlayers = 1.0
[[duct]]\nlength = 0.55\ndiameter = 0.07\nlayers = 1.0
[[obstacle]]\nat = 0.3\nresistance = 6.0\ninertia = 0.004
[[branch]]\nat = 0.6\nnecks = 1.0\nneck_diameter = 0.02\nneck_length = 0.05\ncavity_diameter = 0.02\ncavity_depth = 0.1\nlayers = 0.0
[[source]]\nat = 0.40\nthickness = 1e-8\npower = 1.2e-11\nshare = 1.0\nsensitivity = {gain}\ntimes = \"seconds\"
delay = [{{ weight = 1.0, mean = 1.2e-3 }}]"
        ),
        GAS,
    );
    let network = format!(
        "{SEARCH}[upstream]\ntype = \"constant\"\nmodulus = 0.99\nangle = 0.0
[downstream]\ntype = \"constant\"\nmodulus = 0.97\nangle = 3.0
[[element]]\ntype = \"duct\"\nlength = 0.25\ndiameter = 0.1\nwall = \"zwikker-kosten\"
[[element]]\ntype = \"duct\"\nlength = 0.12\ndiameter = 0.032\nwall = \"zwikker-kosten\"
[[element]]\ntype = \"duct\"\nlength = 0.55\ndiameter = 0.07\nwall = \"zwikker-kosten\"
[[element]]\ntype = \"feedback\"\nat = 0.3\nmu = {{ gain = 1.0, numerator = [6.0, {mass}] }}
[[element]]\ntype = \"flame\"\nat = 0.4\ngain = 0.3\ndelay = 1.2e-3
[[element]]\ntype = \"quarter-wave\"\nat = 0.6\nlength = 0.15\narea = {area}\n",
        mass = 0.004 * 101_325.0 / 287.05 / 293.15,
        area = 1e-4 * std::f64::consts::PI,
    );
    let (a, b) = (by_bench(&bench, "point,flow,T_amb\na,1e-8,293.15\n"), by_network(&network));
    assert!(a.len() == b.len() && a.len() >= 4, "{a:?} {b:?}");
    for (a, b) in a.iter().zip(&b) {
        assert!((a - b).norm() < 1e-6 * b.norm(), "{a} by the bench, {b} by the network");
    }
}

#[test]
fn order_mean_flow_against_the_chain_of_full_balances() {
    // The bench keeps terms of first order in the Mach number, the network's chain all: their difference must
    // fall as its square.
    let rise = 600.0;
    let heat_per_flow = 101_325.0 / 287.05 / 293.15 * 3.5 * 287.05 * rise;
    let differences: Vec<Vec<f64>> = [4e-4, 8e-4, 16e-4]
        .iter()
        .map(|flow| {
            let bench = truth(
                &format!(
                    "upstream = {{ type = \"reflection\", modulus = 0.95, angle = 0.0 }}
downstream = {{ type = \"reflection\", modulus = 0.95, angle = 3.0 }}
[[duct]]\nlength = 0.25\ndiameter = 0.1\nlayers = 0.0
[[duct]]\nlength = 0.12\ndiameter = 0.04\nlayers = 0.0
[[duct]]\nlength = 0.55\ndiameter = 0.07\nlayers = 0.0
[[source]]\nat = 0.45\nthickness = 1e-8\npower = {}\nshare = 1.0\nsensitivity = 0.15\ntimes = \"seconds\"
delay = [{{ weight = 1.0, mean = 1.2e-3 }}]",
                    heat_per_flow * flow
                ),
                GAS,
            );
            let mut network = format!(
                "{SEARCH}[flow]\nvelocity = {}\nentropy_waves = false
[upstream]\ntype = \"constant\"\nmodulus = 0.95\nangle = 0.0
[downstream]\ntype = \"constant\"\nmodulus = 0.95\nangle = 3.0\n",
                flow / (0.25 * std::f64::consts::PI * 0.01)
            );
            for (length, diameter, t) in
                [(0.25, 0.1, 293.15), (0.12, 0.04, 293.15), (0.08, 0.07, 293.15), (0.47, 0.07, 293.15 + rise)]
            {
                if t > 300.0 {
                    network.push_str("[[element]]\ntype = \"flame\"\nn = 0.15\ndelay = 1.2e-3\n");
                }
                let _ = writeln!(
                    network,
                    "[[element]]\ntype = \"duct\"\nlength = {length}\ndiameter = {diameter}\ntemperature = {t}"
                );
            }
            let (a, b) = (by_bench(&bench, &format!("point,flow,T_amb\na,{flow},293.15\n")), by_network(&network));
            assert!(a.len() == b.len() && a.len() >= 3, "{a:?} {b:?}");
            a.iter().zip(&b).map(|(a, b)| (a - b).norm() / TAU).collect()
        })
        .collect();
    for mode in 0..differences[0].len() {
        for pair in differences.windows(2) {
            let slope = (pair[1][mode] / pair[0][mode]).log2();
            assert!((slope - 2.0).abs() < 0.25, "mode {mode}: {differences:?} Hz");
        }
    }
}
