"""The steps of a study beside its ranking: the program's numbers, tables, what a notebook shows, and Ctrl-C in the middle."""

import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any, List, Tuple

import numpy as np
import pandas as pd
import pytest
import rijke
from conftest import ROOT

FOLDER = ROOT / "examples" / "quarter-wave"
AT = [{"x_g": 0.15, "Q": 12.0}, {"x_g": 0.24, "Q": 60.0}]


@pytest.fixture(scope="module")
def ranked() -> rijke.Study:
    study = rijke.Study(FOLDER)
    study.run(trusted="laplace")
    return study


@pytest.fixture(scope="module")
def theirs(program: Path, tmp_path_factory: pytest.TempPathFactory) -> Any:
    """What the program prints as JSON about a ranked copy of the study."""
    folder = tmp_path_factory.mktemp("steps") / "study"
    shutil.copytree(FOLDER, folder, ignore=shutil.ignore_patterns("results"))
    subprocess.run([program, "rank", folder, "--one-start", "--quiet"], check=True)

    def call(command: str, *words: str) -> Any:
        ended = subprocess.run([program, command, folder, *words, "--json"], check=True, capture_output=True, text=True)
        return json.loads(ended.stdout)

    return call


def test_exact_predictions_are_those_of_the_program(ranked: rijke.Study, theirs: Any) -> None:
    words = [w for at in AT for w in ("--at", ",".join(f"{k}={v}" for k, v in at.items()))]
    told = theirs("predict", *words)["points"]
    frame = ranked.predict(AT)
    assert list(frame["point"]) == [one["point"] for one in told] and len(frame) == 4
    for k, name in enumerate(("", "_sd", "_model_sd")):
        assert list(frame[f"growth_rate{name}"]) == [one["growth_rate"][k] for one in told]
    assert list(frame["averaged_angular_frequency"]) == [one["averaged"]["angular_frequency"][0] for one in told]
    assert frame.equals(ranked.predict(pd.DataFrame(AT), stage="heat"))
    assert len(ranked.predict()) == 48 and frame.attrs["left_out"] == {}
    with pytest.raises(rijke.InputError, match="no factor called `x_q`"):
        ranked.predict([{"x_q": 0.1}])


def test_exact_what_to_measure_next_is_that_of_the_program(ranked: rijke.Study, theirs: Any) -> None:
    found = ranked.next(models=True, points=2)
    assert found.record == theirs("next", "--models", "--points", "2")
    assert ranked.next(about=AT[1]).record == theirs("next", "--about", "x_g=0.24,Q=60")
    assert ranked.next(at=AT, pressures=False).record["points"] == theirs(
        "next", "--without-pressures", "--at", "x_g=0.15,Q=12", "--at", "x_g=0.24,Q=60"
    )["points"]
    assert list(found.plan["point"]) == [step["point"] for step in found.record["plan"]]
    assert found.frame["nats"].is_monotonic_decreasing and "nats" in found._repr_html_()


def test_exact_a_check_is_that_of_the_program(ranked: rijke.Study, theirs: Any) -> None:
    stages = theirs("check")["stages"]
    widths = [w for stage in stages for model in stage["models"] for _, w in model["widths"]]
    frame = ranked.check()
    assert list(frame["width"]) == widths and set(frame["stage"]) == {"tube", "gauze", "heat"}


def test_exact_records_are_processed_as_by_the_program(
    program: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RIJKE", str(program))
    folder = tmp_path / "study"
    shutil.copytree(ROOT / "examples" / "juniper-yoko-2022", folder)
    lab = ["lab", "--rows", "C3,H180", "--repeats", "2", "--out", str(folder / "records"), "--quiet"]
    subprocess.run([str(program), *lab], check=True)
    study = rijke.Study(folder)
    frame = study.process()
    assert len(frame) > 19 and (frame["growth_rate"] < 0).any() and (frame["angular_frequency_sd"] > 0).all()
    flow = study.flow()
    assert {run["heater_m"] for run in flow["runs"]} and (folder / "base" / "states.json").is_file()
    with pytest.raises(rijke.InputError, match="exists already") as refused:
        study.process()
    assert refused.value.remedy is not None and "--force" in refused.value.remedy
    monkeypatch.setenv("RIJKE", "")
    monkeypatch.setenv("PATH", "")
    with pytest.raises(rijke.InputError, match="is not installed"):
        study.flow(force=True)


def test_behaviour_until_a_stage(program: Path, tmp_path: Path) -> None:
    results = rijke.Study(FOLDER).run(trusted="laplace", until="gauze")
    assert list(results.stages) == ["tube", "gauze"]
    folder = tmp_path / "study"
    shutil.copytree(FOLDER, folder, ignore=shutil.ignore_patterns("results"))
    subprocess.run([program, "rank", folder, "--one-start", "--until", "gauze", "--quiet"], check=True)
    for stage in results:
        assert stage.record == json.loads((folder / "results" / "numbers" / f"stage-{stage.id}.json").read_text())
    with pytest.raises(rijke.InputError, match="no stage called `heaat`"):
        rijke.Study(FOLDER).run(until="heaat")


def test_exact_xarray_holds_the_tables(ranked: rijke.Study, tube: str) -> None:
    results = ranked._results
    assert results is not None
    heat = results["heat"]
    assert results.xarray["ln_marginal"].attrs["units"] == "nats" and results.xarray.sizes["model"] == len(results.frame)
    data = heat.xarray
    assert np.array_equal(data["growth_rate"], heat.predictions["growth_rate"]) and data["growth_rate_sd"].attrs["units"] == "1/s"
    network = rijke.Network.from_file(tube)
    modes = network.modes()
    assert np.array_equal(modes.xarray["s"], modes.s) and modes.xarray["frequency_hz"].attrs["units"] == "Hz"
    along = network.along(modes[0])
    assert np.array_equal(along.xarray["by_heat"], along.by_heat) and along.xarray["x"].attrs["units"] == "m"
    response = network.response([100.0, 200.0])
    assert np.array_equal(response.xarray["pressure"], response.pressure) and response.xarray["velocity"].attrs["units"] == "m/s"
    frame = response.frame.set_index(["frequency_hz", "place"])
    assert frame.loc[(200.0, 1), "pressure"] == response.pressure[1, 1]


def test_behaviour_progress_is_a_bar_in_a_notebook(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    import IPython.display
    from rijke import _progress

    told: List[Tuple[int, int]] = []
    rijke.search(FOLDER, stage="tube", trusted="laplace", progress=lambda done, count, _: told.append((done, count)))
    assert told == sorted(told) and 0 < told[-1][0] <= told[-1][1]
    model = rijke.OwnModel("constant", [rijke.Parameter("a", rijke.normal(0, 1))], lambda a: [a[0]])
    rijke.rank([model], rijke.Data([0.1], 0.1), progress=True)
    assert "model 1 of 1: constant" in capsys.readouterr().err
    shown: List[str] = []

    class Handle:
        def update(self, html: Any) -> None:
            shown.append(html.data)

    monkeypatch.setattr(_progress, "_in_notebook", lambda: True)
    def display(html: Any, display_id: bool) -> Handle:
        shown.append(html.data)
        return Handle()

    monkeypatch.setattr(IPython.display, "display", display)
    rijke.rank([model], rijke.Data([0.1], 0.1), progress=True)
    assert [text.split("</progress>")[1].strip() for text in shown] == ["model 0 of 1 constant", "model 1 of 1"]


def test_behaviour_other_threads_go_on_while_a_stage_is_trained() -> None:
    ticks, over = [0], threading.Event()

    def count() -> None:
        while not over.wait(0.001):
            ticks[0] += 1

    thread = threading.Thread(target=count)
    thread.start()
    start = time.perf_counter()
    rijke.Study(FOLDER).run(trusted="laplace", until="tube")
    spent = time.perf_counter() - start
    over.set()
    thread.join()
    # Many a tick, however busy the machine: a lock that is held lets none through.
    assert ticks[0] > 5 and spent > 0.0


@pytest.mark.skipif(os.name != "posix", reason="sends a signal")
def test_behaviour_ctrl_c_stops_within_a_stage() -> None:
    script = (
        "import rijke\n"
        "def news(done, count, title):\n"
        "    if done == 0: print('go', flush=True)\n"
        f"rijke.Study({str(FOLDER)!r}).run(progress=news)\n"
        "print('ended')\n"
    )
    child = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert child.stdout is not None and child.stdout.readline() == "go\n"
    threading.Event().wait(0.3)
    child.send_signal(signal.SIGINT)
    said, wrong = child.communicate(timeout=120)
    assert "KeyboardInterrupt" in wrong and "ended" not in said and child.returncode != 0
