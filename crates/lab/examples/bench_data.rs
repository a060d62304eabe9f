//! Makes the observations of the example folders again, or many sets of one truth. From the root of the
//! repository:
//!
//! ```sh
//! cargo run --release -p rijke-lab --example bench_data                       # the three folders, seed 1
//! cargo run --release -p rijke-lab --example bench_data -- TRUTH OUT 20       # OUT/1 ... OUT/20, seeds 1 to 20
//! cargo run --release -p rijke-lab --example bench_data -- --true TRUTH       # what is true: modes and k_eu
//! cargo run --release -p rijke-lab --example bench_data -- --table TRUTH POINT # a measured transfer function
//! ```
#![allow(clippy::print_stdout, reason = "an example shows something")]

use rijke_lab::bench::{Bench, BenchError, run};
use std::f64::consts::TAU;
use std::path::Path;

const FOLDERS: [&str; 3] = ["quarter-wave", "ducted-flame-stages", "helmholtz-combustor"];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words[..] {
        [] => {
            for folder in FOLDERS.iter().map(|name| Path::new("examples").join(name)) {
                let seen = run(&folder.join("truth.toml"), &folder.join("observations"), 1)?;
                println!(
                    "{}: {} modes, {} readings",
                    folder.display(),
                    seen.modes.len(),
                    seen.readings.len()
                );
            }
        }
        ["--true", truth] => show(Path::new(truth))?,
        ["--table", truth, point] => table(Path::new(truth), point)?,
        [truth, out, sets] => {
            let bench = Bench::read(Path::new(truth))?;
            for seed in 1..=sets.parse::<u64>()? {
                bench.observe(seed)?.write(&Path::new(out).join(seed.to_string()))?;
            }
            println!("{sets} sets of {truth} in {out}");
        }
        _ => println!("arguments: none | --true TRUTH | --table TRUTH POINT | TRUTH OUT SETS"),
    }
    Ok(())
}

/// Prints one line per mode: frequency, growth rate, and gain and delay -arg(-k_eu)/omega of every source.
fn show(truth: &Path) -> Result<(), BenchError> {
    println!("point,mode,growth_rate [1/s],frequency [Hz],|k_eu| and delay [s] of each source");
    for mode in Bench::read(truth)?.observe(1)?.modes {
        let s = mode.exact;
        print!("{},{},{:.5},{:.5}", mode.point, mode.mode, s.re, s.im / TAU);
        for k in &mode.feedback {
            print!(",{:.6},{:.4e}", k.norm(), -(-k).arg() / s.im);
        }
        println!();
    }
    Ok(())
}

/// Prints the transfer function of the source at `point`, every 20 Hz, with noise of 5 % and 0.05 rad.
fn table(truth: &Path, point: &str) -> Result<(), BenchError> {
    let hz: Vec<f64> = (1..=22).map(|k| 20.0 * f64::from(k)).collect();
    println!(
        "# Virtual: truth of this folder at point {point}, noise of 5 % of the gain and 0.05 rad, seed 1."
    );
    println!("frequency [Hz],gain,phase [rad]");
    for [f, gain, phase] in Bench::read(truth)?.transfer(point, &hz, [0.05, 0.05], 1)?.unwrap_or_default() {
        println!("{f},{gain:.4},{phase:.3}");
    }
    Ok(())
}
