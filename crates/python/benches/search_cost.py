"""What a search costs, against combinations and against workers.

`python crates/python/benches/search_cost.py measure RIJKE FOLDER [STAGE ...]` prints rows for docs/images/search-cost.csv: the study in FOLDER
searched with `--every`, to each STAGE, and if none is named in 1, 2, 4, 8 and 16 shards that share nothing. `... draw` draws
docs/images/search-cost.svg from them.
"""

import csv
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from shutil import copytree, ignore_patterns, rmtree

IMAGES = Path(__file__).resolve().parents[3] / "docs" / "images"


def spent(program, folder, *words):
    """Processor seconds of a search with one thread."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([program, "search", folder, "--one-start", "--every", "--threads", "1", "--quiet", *words], check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measure(program, folder, *stages):
    import json

    with tempfile.TemporaryDirectory() as scratch:
        copy = Path(scratch) / "study"
        copytree(folder, copy, ignore=ignore_patterns("results", "search"))
        for stage in stages:
            seconds = spent(program, copy, "--stage", stage)
            found = json.loads((copy / "search" / "search.json").read_text())
            print(f"{Path(folder).name},{stage},{found['combinations']},{found['models']},1,{seconds:.2f},{seconds:.2f}", flush=True)
            rmtree(copy / "search")
        for shards in () if stages else (1, 2, 4, 8, 16):
            seconds = []
            for k in range(1, shards + 1):
                seconds.append(spent(program, copy, "--shard", f"{k}/{shards}"))
                part = json.loads((copy / "search" / "parts" / f"{k}-of-{shards}.json").read_text())
                rmtree(copy / "search" / "tasks")
            words = [Path(folder).name, part["stages"][-1], part["combinations"], part["models"], shards]
            print(*words, f"{max(seconds):.2f}", f"{sum(seconds):.2f}", sep=",", flush=True)
            rmtree(copy / "search")


def draw():
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams.update({"svg.hashsalt": "rijke", "svg.fonttype": "none"})  # the same bytes each time
    import matplotlib.pyplot as plt

    rows = list(csv.DictReader((IMAGES / "search-cost.csv").open()))
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.4, 3.8), constrained_layout=True)
    for study, mark in zip(sorted({row["study"] for row in rows}), "os^"):
        one = [row for row in rows if row["study"] == study and row["shards"] == "1"]
        one.sort(key=lambda row: int(row["combinations"]))
        left.loglog([int(r["combinations"]) for r in one], [float(r["in_all_s"]) for r in one], mark + "-", label=study)
        many = [row for row in rows if row["study"] == study and row["stage"] == one[-1]["stage"]]
        if len(many) > 1:
            many.sort(key=lambda row: int(row["shards"]))
            shards = [int(row["shards"]) for row in many]
            right.loglog(shards, [float(row["in_all_s"]) for row in many], mark + "--", label=f"{study}: all shards")
            right.loglog(shards, [float(row["longest_s"]) for row in many], mark + "-", label="the longest shard")
            first = float(many[0]["in_all_s"])
            right.loglog(shards, [first / n for n in shards], color="0.7", label="one run / shards")
    left.set_xlabel("Combinations")
    right.set_xlabel("Shards")
    right.set_xticks([1, 2, 4, 8, 16], ["1", "2", "4", "8", "16"])
    for tag, panel in zip("ab", (left, right)):
        panel.set_title(f"({tag})", loc="left")
        panel.set_ylabel("Processor time / s")
        panel.tick_params(which="both", direction="in", top=True, right=True)
        # Below the panel, where it covers no line.
        panel.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), frameon=False)
    figure.savefig(IMAGES / "search-cost.svg", metadata={"Date": None})


if __name__ == "__main__":
    measure(*sys.argv[2:]) if sys.argv[1] == "measure" else draw()
