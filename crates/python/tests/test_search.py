"""The search over combinations: the program's record, Dask with a worker that is killed, Ctrl-C."""

import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import pytest
import rijke
from conftest import ROOT

FOLDER = ROOT / "examples" / "ducted-flame-stages"
# Of its three stages the last takes most of the time.
STAGE = "burner"


@pytest.fixture(scope="module")
def found() -> rijke.Search:
    return rijke.search(FOLDER, stage=STAGE, trusted="laplace")


def test_exact_the_record_is_that_of_the_program(found: rijke.Search, program: Path, tmp_path: Path) -> None:
    folder = tmp_path / "study"
    shutil.copytree(FOLDER, folder, ignore=shutil.ignore_patterns("results", "search"))
    subprocess.run([program, "search", folder, "--stage", STAGE, "--one-start"], check=True, capture_output=True)
    assert found.record == json.loads((folder / "search" / "search.json").read_text())


def test_exact_tables_hold_the_record(found: rijke.Search) -> None:
    frame = found.frame
    assert frame["probability"].sum() == pytest.approx(1.0) and frame["behind"][0] == 0.0
    assert list(frame["ln_evidence"]) == sorted(frame["ln_evidence"], reverse=True)
    assert frame["greedy"].sum() == 1 and frame["probability"][frame["greedy"]].iloc[0] == found.greedy["probability"]
    sums = found.choices.groupby("role")["probability"].sum()
    assert sums.to_numpy() == pytest.approx(1.0)
    assert "of 32 combinations" in repr(found) and found.given_up_at_most < 1e-3


@pytest.mark.slow
def test_exact_dask_finds_the_same_when_a_worker_is_killed(found: rijke.Search, tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    tasks = tmp_path / "tasks"
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, local_directory=tmp_path
    ) as cluster, distributed.Client(cluster) as client:
        workers = list(client.run(os.getpid).values())
        killed = []

        def kill() -> None:
            while not (tasks.is_dir() and len(list(tasks.glob("*.json"))) > 5):
                time.sleep(0.01)
            os.kill(workers[0], signal.SIGKILL)
            killed.append(workers[0])

        thread = threading.Thread(target=kill)
        thread.start()
        on_workers = rijke.search(FOLDER, stage=STAGE, client=client, trusted="laplace", parts=4, tasks=tasks)
        thread.join()
        left = list(client.run(os.getpid).values())
    assert killed and killed[0] not in left
    assert on_workers.record == found.record


def test_message_a_search_refuses_what_is_not_there() -> None:
    with pytest.raises(rijke.InputError, match="burner, flame"):
        rijke.search(FOLDER, stage="flames")
    wrong: Any = "blindly"
    with pytest.raises(rijke.InputError, match="blindly"):
        rijke.search(FOLDER, trusted=wrong)


def test_behaviour_ctrl_c_stops_a_search() -> None:
    script = (
        "import os, signal, threading, rijke\n"
        "threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT)).start()\n"
        f"rijke.search({str(FOLDER)!r}, within=None)\n"
    )
    ended = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=120)
    assert ended.returncode != 0 and "KeyboardInterrupt" in ended.stderr
