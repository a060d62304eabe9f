"""Networks: the program's numbers to the last bit, closed forms, other routes to derivatives."""

import json
import pickle
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Dict

import numpy as np
import pytest
import rijke
from conftest import NETWORKS

CLOSED: Dict[str, Any] = {
    "name": "closed tube",
    "upstream": {"type": "closed"},
    "downstream": {"type": "closed"},
    "element": [{"name": "tube", "type": "duct", "length": 0.5, "diameter": 0.05}],
}
SOUND_SPEED = np.sqrt(1.4 * 287.05 * 293.15)


@pytest.mark.parametrize("path", sorted(NETWORKS.glob("*.toml")), ids=lambda path: path.stem)
def test_exact_modes_are_those_of_the_program_to_the_last_bit(path: Path, program: Path) -> None:
    answer = subprocess.run([program, "modes", path, "--format", "json"], capture_output=True, text=True, check=True)
    theirs = json.loads(answer.stdout)
    modes = rijke.Network.from_file(path).modes()
    assert len(modes) == len(theirs["modes"]) > 0
    assert (modes.counted, modes.poles) == (theirs["counted"], theirs["poles"])
    for k, line in enumerate(theirs["modes"]):
        assert modes.frequency_hz[k] == line["frequency_hz"]
        assert modes.growth_rate[k] == line["growth_rate"]
        assert modes.residual[k] == line["residual"]
        assert modes.condition[k] == line["condition"]
        ends = [line[f"by_{name}"] for name in ("upstream_end", "downstream_end", "viscous_loss", "thermal_loss")]
        assert list(modes.shares[k].values()) == ends + [share for _, share in line["by_elements"]]


def test_oracle_closed_tube() -> None:
    modes = rijke.Network.from_dict(CLOSED).modes()
    assert np.allclose(modes.frequency_hz, SOUND_SPEED / (2 * 0.5) * np.arange(1, 3), rtol=1e-12)
    assert np.allclose(modes.growth_rate, 0.0, atol=1e-9)


def test_exact_file_text_and_dictionary_are_one_network(tube: str) -> None:
    import tomllib

    text = Path(tube).read_text()
    three = [
        rijke.Network.from_file(tube),
        rijke.Network.from_str(text),
        rijke.Network.from_dict(tomllib.loads(text)),
    ]
    found = [network.modes().s for network in three]
    assert np.array_equal(found[0], found[1]) and np.array_equal(found[0], found[2])


def test_exact_numbers_of_numpy_are_taken() -> None:
    duct = {"name": "tube", "type": "duct", "length": np.float64(0.5), "diameter": np.float32(0.05), "wall": None}
    assert rijke.Network.from_dict({**CLOSED, "element": (duct,)}).numbers()["tube.length"] == 0.5


def test_exact_solve_of_an_array_is_solve_of_each(tube: str) -> None:
    network = rijke.Network.from_file(tube)
    guesses = network.modes().s.reshape(1, -1) + np.array([[0.0], [3.0j]])
    found = network.solve(guesses)
    assert found.shape == guesses.shape
    assert all(found[i, k] == network.solve(complex(guesses[i, k])) for i in range(2) for k in range(found.shape[1]))
    assert network.solve(np.array(guesses[0, 0])) == found[0, 0]


def test_exact_solve_with_other_numbers_is_solve_of_another_network(tube: str) -> None:
    network = rijke.Network.from_file(tube)
    s = network.modes()[0]
    gains, delays = np.array([0.03, 0.06, 0.09]), np.array([[1e-3], [2e-3]])
    found = network.solve(s, {"heat release.gain": gains, "heat release.delay": delays})
    assert found.shape == (2, 3)
    for i, delay in enumerate(delays[:, 0]):
        for k, gain in enumerate(gains):
            other = network.replace({"heat release.gain": gain, "heat release.delay": delay})
            assert found[i, k] == other.solve(s)
    assert isinstance(network.solve(s, {"heat release.gain": 0.07}), complex)


def test_order_gradients_against_differences_of_eigenvalues(tube: str) -> None:
    network = rijke.Network.from_file(tube)
    s = network.modes()[0]
    gradient = network.gradient(s)
    numbers = network.numbers()
    assert {"gas.temperature", "heater plate.drag", "above the heater.length"} < set(gradient)
    assert not any(name.startswith("search") for name in gradient)
    for name, slope in gradient.items():
        step = 1e-4 * abs(numbers[name])
        ends = network.solve(s, {name: numbers[name] + np.array([step, -step])})
        quotient = (ends[0] - ends[1]) / (2 * step)
        assert abs(slope - quotient) < 1e-6 * abs(quotient) + 1e-8 * abs(s) / abs(numbers[name]), name


def test_exact_budget_adds_up(tube: str) -> None:
    network = rijke.Network.from_file(tube)
    for s in network.modes():
        assert sum(network.budget(s).values()) == pytest.approx(s.real, abs=1e-9)
        assert network.condition(s) > 2.0


def test_order_along_against_a_screen_put_there() -> None:
    network = rijke.Network.from_dict(CLOSED)
    s = network.modes()[0]
    along = network.along(s, 41)
    assert along.x[[0, -1]] == pytest.approx([0.0, 0.5])
    assert abs(along.pressure).max() == pytest.approx(1.0)
    k = 10
    impedance = 101325.0 / (287.05 * 293.15) * SOUND_SPEED
    weak = 1e-5
    screen = {"name": "screen", "type": "screen", "at": along.x[k], "resistance": weak * impedance}
    other = rijke.Network.from_dict({**CLOSED, "element": [*CLOSED["element"], screen]})
    assert (other.solve(s) - s) / weak == pytest.approx(along.by_screen[k], rel=1e-4)


def test_oracle_response_of_a_closed_tube() -> None:
    network = rijke.Network.from_dict({**CLOSED, "upstream": {"type": "anechoic"}})
    frequency = np.array([50.0, 120.0])
    response = network.response(frequency)
    # A wave of 1 Pa and its image: p = e^{-ikx} + e^{-ik(2L - x)}.
    phase = 2 * np.pi * frequency / SOUND_SPEED
    expected = 1 + np.exp(-2j * phase * 0.5)
    assert response.pressure[:, 0] == pytest.approx(expected, rel=1e-12)
    assert response.x == pytest.approx([0.0, 0.5])
    assert network.reflection(frequency, 0) == pytest.approx(np.exp(-2j * phase * 0.5), rel=1e-12)
    rho_c = 101325.0 / (287.05 * 293.15) * SOUND_SPEED
    assert network.impedance(frequency, 0) == pytest.approx(-1j * rho_c / np.tan(phase * 0.5), rel=1e-10)


def test_exact_transfer_and_scattering_of_nothing(tube: str) -> None:
    network = rijke.Network.from_dict({**CLOSED, "element": [
        *CLOSED["element"], {"name": "nothing", "type": "feedback", "at": 0.2, "eu": [0.0, 0.0]}]})
    assert network.transfer([100.0], "nothing", "nothing")[0] == pytest.approx(np.eye(2))
    assert network.scattering([100.0], 1, 1)[0] == pytest.approx(np.array([[0, 1], [1, 0]]), abs=1e-14)


def test_behaviour_pickled_networks_are_the_same(tube: str) -> None:
    network = rijke.Network.from_file(tube)
    copy = pickle.loads(pickle.dumps(network))
    assert type(copy) is rijke.Network
    assert copy.source == network.source
    assert np.array_equal(copy.modes().s, network.modes().s)


def test_behaviour_threads_share_a_network(tube: str) -> None:
    network = rijke.Network.from_file(tube)
    guesses = list(network.modes().s) * 50
    alone = [network.solve(complex(guess)) for guess in guesses]
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(lambda guess: network.solve(complex(guess)), guesses)) == alone


def test_behaviour_memory_of_1000_calls_is_flat(tube: str) -> None:
    def resident() -> int:
        lines = Path("/proc/self/status").read_text().splitlines()
        return next(int(line.split()[1]) for line in lines if line.startswith("VmRSS"))

    network = rijke.Network.from_file(tube)
    s = network.modes()[0]
    numbers = {"heat release.gain": np.linspace(0.05, 0.07, 4)}

    def calls(count: int) -> None:
        for _ in range(count):
            network.solve(s)
            network.solve(s, numbers)
            network.gradient(s, ["heat release.gain"])
            network.along(s, 5)
            network.response([100.0, 200.0])

    calls(200)
    before = resident()
    calls(1000)
    assert resident() - before < 2000  # kB


def test_behaviour_display(tube: str) -> None:
    network = rijke.Network.from_file(tube)
    assert "1 m" in repr(network) and "<table>" in network._repr_html_()
    modes = network.modes()
    assert "7 of 7 modes" in repr(modes) and "heat release" in modes._repr_html_()
    assert list(modes.frame["frequency_hz"]) == list(modes.frequency_hz)
    assert network.along(modes[0], 3).frame.shape[1] == 8


def test_behaviour_plots_return_axes(tube: str) -> None:
    import matplotlib

    matplotlib.use("agg")
    network = rijke.Network.from_file(tube)
    assert network.plot_modes().get_xlabel().startswith("growth rate")
    assert len(network.along(network.modes()[0]).plot()) == 2
    assert network.response(np.linspace(50, 300, 20)).plot(3).get_ylabel().startswith("|p|")


def test_what_is_no_mode_has_no_derivatives() -> None:
    tube = rijke.Network.from_file(NETWORKS / "rijke-tube.toml")
    s = tube.modes().s[0]
    tube.budget(complex(f"{s:.5g}"))
    for ask in (tube.budget, tube.gradient, tube.along, tube.condition):
        with pytest.raises(rijke.InputError, match="no eigenvalue"):
            ask(s + 20.0)
