//! Any text as a network file: read it, and find the modes of what is small enough to be quick.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rijke_network::{Root, Workspace, file::read};

fuzz_target!(|text: &str| {
    let Ok(built) = read(text) else { return };
    if built.network.segments().len() > 200 || built.network.travel_time() * built.region.omega[1] > 300.0 {
        return;
    }
    let mut work = Workspace::default();
    let modes = match &built.flow {
        Some(flow) => flow.modes(&built.region),
        None => built.network.modes(&built.laws, &built.region, &mut work),
    };
    for mode in modes.iter().flat_map(|m| &m.modes).take(3) {
        let root = Root { s: mode.s, steps: 0, residual: mode.residual };
        let _ = built.network.along(&built.laws, &root, 3, &mut work);
        let _ = built.flow.as_ref().map(|flow| (flow.budget(&root), flow.condition(&root), flow.along(&root, 3)));
    }
});
