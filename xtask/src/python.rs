//! `cargo xtask python`: the Python package as its users get it, in a fresh environment under target/.

use crate::workspace::{Outcome, at, built, entries, root, succeed};
use std::{path::Path, process::Command};

/// The oldest Python for which the package is built.
const OLDEST: (u32, u32) = (3, 9);

/// Makes a fresh environment, installs the package from the checkout, and runs its tests and the checker of
/// its types. Without Python says so and passes.
pub(crate) fn run() -> Outcome {
    let Some(python) = interpreter() else {
        let (major, minor) = OLDEST;
        eprintln!(
            "python: not tested, because there is no python3 of version {major}.{minor} or newer with venv"
        );
        return Ok(());
    };
    let environment = root().join("target/python");
    if environment.exists() {
        std::fs::remove_dir_all(&environment).map_err(at(&environment))?;
    }
    succeed(Command::new(python).args(["-m", "venv"]).arg(&environment))?;
    let inside = environment.join("bin/python");
    let program = built()?;
    // The build of the package shares the folder `target`, so that nothing is compiled twice.
    let pip = || {
        let mut command = Command::new(&inside);
        command.current_dir(root()).env("CARGO_TARGET_DIR", root().join("target"));
        command.args(["-m", "pip", "--disable-pip-version-check", "--quiet"]);
        command
    };
    succeed(pip().args(["install", ".[test]"]))?;
    succeed(python_in(&inside).args(["-m", "mypy"]))?;
    succeed(python_in(&inside).args(["-m", "mypy.stubtest", "rijke._native", "--ignore-disjoint-bases"]))?;
    succeed(python_in(&inside).args(["-m", "pytest", "--quiet"]).env("RIJKE", program))?;
    wheel(&pip, python, &environment)
}

/// Builds a wheel, looks at its size, and installs it in a second environment.
fn wheel(pip: &dyn Fn() -> Command, python: &str, environment: &Path) -> Outcome {
    /// Bytes.
    const LARGEST: u64 = 8_000_000;
    let wheels = environment.join("wheels");
    succeed(pip().args(["wheel", ".", "--no-deps", "--wheel-dir"]).arg(&wheels))?;
    let file = entries(&wheels)?.into_iter().next();
    let file = file.ok_or_else(|| format!("{}: pip made no wheel", wheels.display()))?;
    let size = std::fs::metadata(&file).map_err(at(&file))?.len();
    if size > LARGEST {
        return Err(format!("{}: {size} bytes, but a wheel may have {LARGEST}", file.display()));
    }
    let second = environment.join("second");
    succeed(Command::new(python).args(["-m", "venv"]).arg(&second))?;
    let inside = second.join("bin/python");
    succeed(Command::new(&inside).args(["-m", "pip", "--quiet", "install"]).arg(&file))?;
    let tube = root().join("fixtures/networks/rig-tube.toml");
    let script =
        "import rijke, sys; print(rijke.__version__, len(rijke.Network.from_file(sys.argv[1]).modes()))";
    succeed(Command::new(&inside).current_dir(&second).args(["-c", script]).arg(tube))?;
    println!("python: tested; the wheel has {:.1} MB", size as f64 / 1e6);
    Ok(())
}

fn python_in(inside: &Path) -> Command {
    let mut command = Command::new(inside);
    command.current_dir(root());
    command
}

/// A Python that is new enough and can make environments.
fn interpreter() -> Option<&'static str> {
    let (major, minor) = OLDEST;
    let script = format!("import sys, venv, ensurepip; sys.exit(sys.version_info < ({major}, {minor}))");
    let works =
        |name: &&str| Command::new(name).args(["-c", &script]).output().is_ok_and(|o| o.status.success());
    ["python3", "python"].into_iter().find(works)
}
