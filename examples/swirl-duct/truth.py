"""Writes the virtual observations of this example, from a dispersion relation of its own. Nothing of it is shared with the models.

A closed supply duct, a flame at its end, a chamber that ends open. Gas at rest, without losses but for the open end. The flame answers by
three delays, each gamma-distributed: no candidate says so.

    python3 truth.py
"""

import cmath
import math
import random

GAMMA, GAS, T1, T2 = 1.4, 287.0, 300.0, 1890.0
C1, C2 = math.sqrt(GAMMA * GAS * T1), math.sqrt(GAMMA * GAS * T2)
IMPEDANCE = [C1 / T1, C2 / T2]  # rho c, but for a factor that both have
SUPPLY, THETA = 0.35, T2 / T1 - 1.0
ETA, EXTRA = 0.85, 0.016  # the open end
# weight, mean delay, spread
DELAYS = [(1.0, 2.6e-3, 0.7e-3), (0.8, 4.7e-3, 0.9e-3), (-0.8, 6.6e-3, 1.2e-3)]


def flame(s):
    """The flame transfer function."""
    answer = 0.0
    for weight, mean, spread in DELAYS:
        shape = (mean / spread) ** 2
        answer += weight * cmath.exp(-shape * cmath.log(1.0 + s * mean / shape))
    return answer


def dispersion(s, chamber):
    """Zero at the modes: the impedance of the chamber against that of the supply, times velocities."""
    r = -ETA * cmath.exp(-2.0 * s * (chamber + EXTRA) / C2)
    a = s * SUPPLY / C1
    return (1.0 - r) * cmath.cosh(a) * IMPEDANCE[0] + (1.0 + r) * cmath.sinh(a) * (1.0 + THETA * flame(s)) * IMPEDANCE[1]


def root(s, chamber):
    """Newton's method with a numerical slope."""
    for _ in range(60):
        h = 1e-4 * abs(s)
        slope = (dispersion(s + h, chamber) - dispersion(s - h, chamber)) / (2.0 * h)
        step = dispersion(s, chamber) / slope
        s -= step
        if abs(step) < 1e-10 * abs(s):
            return s
    return None


def modes(chamber):
    """All modes from 60 to 620 Hz, the lowest first."""
    found = []
    for hertz in range(60, 621, 10):
        for growth in (-300.0, -150.0, -50.0, 50.0, 150.0):
            s = root(complex(growth, 2.0 * math.pi * hertz), chamber)
            if s is None or not (60.0 < s.imag / (2.0 * math.pi) < 620.0 and abs(s.real) < 400.0):
                continue
            if all(abs(s - other) > 1e-3 for other in found):
                found.append(s)
    return sorted(found, key=lambda s: s.imag)


def main():
    """Writes flame.csv and modes.csv."""
    noise = random.Random(7)
    with open("observations/flame.csv", "w") as file:
        file.write("f [Hz],re [1],im [1]\n")
        for hertz in range(20, 621, 20):
            z = flame(2j * math.pi * hertz) + complex(noise.gauss(0.0, 0.02), noise.gauss(0.0, 0.02))
            file.write(f"{hertz},{z.real:.5f},{z.imag:.5f}\n")
    with open("observations/modes.csv", "w") as file:
        file.write("point,mode,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n")
        for chamber in (300, 400, 500, 600):
            # The second mode grows: what rings by itself has no decay to be measured. The third is close to it.
            found = modes(1e-3 * chamber)
            for label, s in (("low", found[0]), ("high", found[3])):
                growth, hertz = s.real + noise.gauss(0.0, 2.0), s.imag / (2.0 * math.pi) + noise.gauss(0.0, 0.3)
                file.write(f"duct-{chamber},{label},{growth:.2f},2,{hertz:.2f},0.3\n")
    for chamber in (300, 400, 450, 500, 600, 700):
        print(chamber, ["%.2f 1/s, %.2f Hz" % (s.real, s.imag / (2.0 * math.pi)) for s in modes(1e-3 * chamber)])


if __name__ == "__main__":
    main()
