"""What the truth is in King's form: gain and delay of k_eu, which the bench of the virtual laboratory prints.

    cargo run --release -p rijke-lab --example bench_data -- --true examples/quarter-wave/truth.toml > true.csv
    python examples/quarter-wave/king.py true.csv          (or, of truth-2.toml: king.py true.csv lag)

Prints the range of the gain over the modes, and the gain and the delay (in units of Lighthill's, 0.2 d/U) of the form
that fits all k_eu best: real and imaginary part alike, each mode weighted by sin(2 k x) of its place.
"""

import csv
import sys
from pathlib import Path

import numpy as np

lag = sys.argv[2:] == ["lag"]
area, wire = np.pi * 0.025**2, 3e-4
with open(Path(__file__).with_name("campaign.csv"), encoding="utf-8") as file:
    points = {row["point"]: row for row in csv.DictReader(line for line in file if not line.startswith("#"))}

modes = []
with open(sys.argv[1], encoding="utf-8") as file:
    for cells in csv.reader(file):
        if len(cells) < 6 or cells[0] not in points:
            continue
        point = {key.split(" ")[0]: value for key, value in points[cells[0]].items()}
        t, power, flow = (float(point[key]) for key in ("T_amb", "Q", "flow"))
        u, rho = flow / 60_000 / area, 101_325 / 287.05 / t
        mu = 1.716e-5 * (t / 273.15) ** 1.5 * (273.15 + 110.4) / (t + 110.4)
        slope = ((u * wire * rho / mu * 0.71 * np.pi / 2) ** -0.5 + 2) * u
        king = 0.4 / (1.4 * 101_325 * area) * power / slope
        s = complex(float(cells[2]), 2 * np.pi * float(cells[3]))
        k = float(cells[4]) * np.exp(-1j * s.imag * float(cells[5]))
        weight = np.sin(2 * s.imag / 346 * float(point["x_g"]) / 1000)
        modes.append((k, king, s, 0.2 * wire / u, weight))
k, king, s, unit, weight = map(np.array, zip(*modes))

print(f"{len(k)} modes, |k_eu| over King's: {min(abs(k) / king):.4f} to {max(abs(k) / king):.4f}")
gain, delay = 0.9, 2.0
for _ in range(30):  # Gauss and Newton
    turn = 1 / (1 + s * delay * unit) if lag else np.exp(-s * delay * unit)
    by_delay = -gain * s * unit * (turn**2 if lag else turn)
    columns = np.stack([weight * king * turn, weight * king * by_delay], axis=1)
    left = weight * (k - gain * king * turn)
    step = np.linalg.lstsq(np.vstack([columns.real, columns.imag]), np.hstack([left.real, left.imag]), rcond=None)[0]
    gain, delay = gain + step[0], delay + step[1]
print(f"best: k1 = {gain:.4f}, k2 = {delay:.4f}")
