//! The warm path allocates nothing: its own binary, because it replaces the allocator.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use rijke_network::wall::Wall;
use rijke_network::{
    At, Coefficients, Laws, Network, Newton, Places, Segment, Sensitivities, Slot, Workspace,
    levine_schwinger,
};
use rijke_numerics::{C64, Order};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

struct Counting;

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

#[allow(unsafe_code, reason = "an allocator that counts is the only way to see allocations")]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.set(COUNT.get() + 1);
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

struct Rig;

impl Coefficients for Rig {
    fn parameters(&self) -> usize {
        0
    }
    fn laws(&self) -> usize {
        3
    }
    fn fill(&self, at: &At, laws: &mut Laws) {
        let wall = Wall {
            density: 1.2041,
            sound_speed: 343.2,
            viscosity: 1.8134e-5,
            prandtl: 0.71,
            gamma: 1.4,
            diameter: 0.0474,
        };
        let loss = wall.paper(at.s());
        laws.set_analytic(0, loss.viscous);
        laws.set_analytic(1, loss.thermal);
        let factor = C64::new(0.0, -0.0237 / 343.2);
        let [r, r1, r2] = levine_schwinger::reflection(at.s() * factor);
        laws.set_analytic(2, [r, r1 * factor, r2 * factor * factor]);
    }
}

#[test]
fn exact_the_warm_path_allocates_nothing() {
    let mut net = Network::new(vec![Segment::new(0.02, 1.765e-3, 343.2, 1.2041); 50]).unwrap();
    for i in 0..50 {
        net.attach(Slot::Viscous(i), 0, 1.0).unwrap();
        net.attach(Slot::Thermal(i), 1, 1.0).unwrap();
    }
    net.attach(Slot::Upstream, 2, 1.0).unwrap();
    net.attach(Slot::Downstream, 2, 1.0).unwrap();
    let places = Places { at: (10..50).step_by(5).collect(), reference: 35 };
    let (mut work, mut all) = (Workspace::default(), Sensitivities::default());
    let mut run = || {
        let root = net.solve(&Rig, C64::new(-6.0, 1040.0), &Newton::default(), &mut work).unwrap();
        net.sensitivities(&Rig, &root, &places, &mut all, &mut work).unwrap();
        let seen = net.impedance_at(&Rig, C64::new(0.0, 900.0), 10, Order::Value, &mut work).unwrap();
        (root.s, seen.value())
    };
    let first = run();
    let before = COUNT.get();
    let second = run();
    assert_eq!(COUNT.get() - before, 0);
    assert_eq!(first, second);
}
