"""The input impedance of one bore, side by side: rijke from Python and openwind.

    pip install . openwind && python crates/python/benches/against_openwind.py

A bore of fifty cylinders of different radii with the losses of Zwikker and Kosten (Bessel functions), closed at its far end by a
rigid wall, in dry air at 25 degrees C: the formulas of both are the same, so their numbers are compared before they are timed.
openwind computes by transfer matrices (``compute_method="TMM"``), and steps add no mass (``discontinuity_mass=False``).
"""

import json
import time
from typing import Callable, List

import numpy as np
import rijke
from openwind import ImpedanceComputation
from openwind.continuous import Physics

N, LENGTH, TEMPERATURE = 50, 1.0, 298.15
RADII = 0.007 + 0.004 * np.linspace(0, 1, N) ** 2 + 0.0005 * np.sin(np.arange(N))
FREQUENCY = np.linspace(50.0, 3000.0, 2000)


def bore() -> List[list]:
    """Rows of openwind: from, to (m), radius at both, kind."""
    edges = np.linspace(0.0, LENGTH, N + 1)
    return [[a, b, r, r, "linear"] for a, b, r in zip(edges[:-1], edges[1:], RADII.tolist())]


def network(air: Physics) -> rijke.Network:
    """The same bore; feedback of nothing marks its mouthpiece."""
    rho, c, gamma = (float(f(0.0)) for f in (air.rho, air.c, air.gamma))
    mu, heat = float(air.mu(0.0)), float(air.Cp(0.0) / air.kappa(0.0))
    constant = c * c / (gamma * TEMPERATURE)
    text = [
        f"[gas]\ntemperature = {TEMPERATURE}\ngamma = {gamma}\ngas_constant = {constant!r}",
        f"pressure = {rho * constant * TEMPERATURE!r}\nviscosity = {mu!r}\nprandtl = {mu * heat!r}",
        "[search]\nfrequency_hz = [20, 200]\ngrowth_rate = [-100, 10]",
        "[upstream]\ntype = 'closed'\n[downstream]\ntype = 'closed'",
    ]
    for k, radius in enumerate(RADII.tolist()):
        size = f"length = {LENGTH / N}\ndiameter = {2 * radius!r}"
        text.append(f"[[element]]\ntype = 'duct'\n{size}\nwall = 'zwikker-kosten'")
        if k == 0:
            text.append("[[element]]\nname = 'mouthpiece'\ntype = 'feedback'\nat = 0.0\neu = [0.0, 0.0]")
    return rijke.Network("\n".join(text))


def least(run: Callable[[], object], rounds: int) -> float:
    """Least processor time of one call, s: what other programs do at the time hardly counts."""
    times = []
    for _ in range(rounds):
        start = time.process_time()
        run()
        times.append(time.process_time() - start)
    return min(times)


def main() -> None:
    options = dict(
        temperature=TEMPERATURE - 273.15,
        losses="bessel",
        radiation_category="closed",
        discontinuity_mass=False,
        compute_method="TMM",
        nondim=False,
    )
    theirs = ImpedanceComputation(FREQUENCY, bore(), **options)
    tube = network(Physics(TEMPERATURE - 273.15))
    ours = tube.impedance(FREQUENCY, "mouthpiece") / (np.pi * RADII[0] ** 2)
    apart = np.max(np.abs(ours / theirs.impedance - 1.0))
    mine = least(lambda: tube.impedance(FREQUENCY, "mouthpiece"), 15) / len(FREQUENCY)
    other = least(lambda: theirs.recompute_impedance_at(FREQUENCY), 5) / len(FREQUENCY)
    found = {
        "largest_relative_difference": float(apart),
        "rijke_us_per_frequency": 1e6 * mine,
        "openwind_us_per_frequency": 1e6 * other,
        "openwind_over_rijke": other / mine,
    }
    print(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
