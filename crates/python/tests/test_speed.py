"""What a caller waits for: the import, and a call beside the work itself. Limits are wide; docs/records/python.md has the figures."""

import subprocess
import sys
import time
from typing import Any, Callable

import numpy as np
import rijke


def best(call: Callable[[], Any], rounds: int, inner: int) -> float:
    """Least time of a call, s."""
    times = []
    for _ in range(rounds):
        start = time.perf_counter()
        for _ in range(inner):
            call()
        times.append((time.perf_counter() - start) / inner)
    return min(times)


def test_behaviour_import_is_quick_and_loads_nothing_else() -> None:
    script = (
        "import sys, time; start = time.perf_counter(); import rijke; spent = time.perf_counter() - start\n"
        "print(spent, *({'numpy', 'pandas', 'matplotlib', 'arviz'} & set(sys.modules)))"
    )

    def spent() -> float:
        words = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout.split()
        assert len(words) == 1, words
        return float(words[0])

    assert min(spent() for _ in range(5)) < 0.050


def test_behaviour_a_call_costs_little_beside_its_work() -> None:
    tube = rijke.Network.from_dict({
        "upstream": {"type": "open"}, "downstream": {"type": "closed"},
        "element": [{"type": "duct", "length": 1.0, "diameter": 0.05}],
    })
    s = tube.modes()[0]
    # One duct: next to no work, so that this is the cost of a call.
    assert best(lambda: tube.solve(s), 20, 2000) < 3e-6


def test_behaviour_a_vector_is_not_slower_than_its_elements(tube: str) -> None:
    network = rijke.Network.from_file(tube)
    s = network.modes()[0]
    guesses = np.full(175, s)
    alone = best(lambda: [network.solve(s) for _ in range(175)], 5, 2)
    assert best(lambda: network.solve(guesses), 10, 2) < 1.05 * alone
