"""What a call from Python costs beside the work itself, and what a vector of cases costs.

    pip install ".[all]" && RAYON_NUM_THREADS=1 python crates/python/benches/calls.py

The time of the work is that of one case of a large vector in one thread: there, Python is called once for all of them.
"""

import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import rijke

ROOT = Path(__file__).resolve().parents[3]


def least(call, rounds=40, inner=1):
    """Least time of a call, us."""
    best = np.inf
    for _ in range(rounds):
        start = time.perf_counter()
        for _ in range(inner):
            call()
        best = min(best, (time.perf_counter() - start) / inner * 1e6)
    return best


def main():
    for file in ("closed-open.toml", "rig-tube.toml", "rijke-tube.toml"):
        network = rijke.Network.from_file(ROOT / "fixtures" / "networks" / file)
        s = network.modes()[0] + 1j
        guesses = np.full(2000, s)
        work = least(lambda: network.solve(guesses), 200) / len(guesses)
        call = least(lambda: network.solve(s), 200, 500)
        vector = np.full(175, s)
        print(f"{file:18} solve {call:7.2f} us, the work {work:7.2f} us, a call {call - work:5.2f} us; ", end="")
        print(f"175 at once: {least(lambda: network.solve(vector), 1000) / 175 / work:.3f} of the work")
    model = rijke.Study(ROOT / "examples" / "quarter-wave").run(trusted="laplace")["heat"].posterior.model
    n, a = len(model.points), model.medians
    many = np.tile(a, (400, 1))
    for name in ("solve", "jacobian", "hessian"):
        call = getattr(model, name)
        print(f"model of {n} observations, {name}: {least(lambda: call(a)):.0f} us; ", end="")
        print(f"{least(lambda: call(many), 5) / 400:.0f} us each in a vector of 400")
    script = "import time; t = time.perf_counter(); import rijke; print(time.perf_counter() - t)"
    imports = [float(subprocess.check_output([sys.executable, "-c", script])) * 1e3 for _ in range(10)]
    print(f"import rijke: {min(imports):.1f} to {max(imports):.1f} ms")


if __name__ == "__main__":
    main()
