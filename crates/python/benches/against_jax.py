"""One problem, side by side: eigenvalue, gradient and Hessian from Python by rijke and by JAX's jit.

    pip install ".[all]" jax && python crates/python/benches/against_jax.py

A tube of forty segments of warming gas with wall losses, a heater that lags, and two ends: six parameters. Both sides solve for s by
Newton's iteration from the same guess and differentiate the implicit function F(a, s(a)) = 0 exactly; JAX does so within one jitted
function. The numbers of both are compared before they are timed.
"""

import json
import tempfile
import time
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import rijke

jax.config.update("jax_enable_x64", True)

N, LENGTH, DIAMETER, GAMMA, R, P0, MU, PR = 40, 1.0, 0.0474, 1.4, 287.05, 101325.0, 1.813e-5, 0.71
TEMPERATURE = np.linspace(300.0, 340.0, N)
HEATER = 10  # before this segment
NAMES = ["eta", "k", "tau", "r_u", "r_d", "delta"]
A = np.array([1.0, 0.05, 1.5e-3, 0.98, 0.97, 2e-4])
GUESS = 1100j
WALL = "eta * 4/D * sqrt(s*rho*mu)"
ROLES = {
    "wall": ({"eta": "1"}, [("ducts", "mu", WALL), ("ducts", "ep", f"{WALL} * (gamma - 1)/(rho*c)^2 * Pr^(-1/2)")]),
    "heat": ({"k": "1", "tau": "s"}, [("heater", "eu", "-k*exp(-s*tau)")]),
    "upstream": ({"r_u": "1"}, [("upstream", "reflection", "-r_u")]),
    "downstream": ({"r_d": "1", "delta": "s"}, [("downstream", "reflection", "-r_d*exp(-s*delta)")]),
}


def study(folder: Path) -> None:
    """The problem as a study with one observation, which is not what is timed."""
    rig = [
        "name = 'bench'\nsource = 'this file'",
        f"[gas]\ntemperature = 300.0\nviscosity = {MU}",
        "[search]\ngrowth_rate = [-150, 150]\nfrequency_hz = [50, 300]",
        "[upstream]\ntype = 'free'\n[downstream]\ntype = 'free'",
    ]
    for k, temperature in enumerate(TEMPERATURE):
        if k == HEATER:
            rig.append(f"[[element]]\nname = 'heater'\ntype = 'device'\nat = {LENGTH * k / N}")
        rig.append(
            f"[[element]]\nname = 'd{k}'\ntype = 'duct'\nlength = {LENGTH / N}\ndiameter = {DIAMETER}\n"
            f"temperature = {temperature}\nwall = 'none'"
        )
    laws = []
    for role, (units, effects) in ROLES.items():
        laws.append(f"[[candidate]]\nid = '{role}.1'\nrole = '{role}'\nname = '{role}'\ncite = ['this file']")
        for name, unit in units.items():
            value = A[NAMES.index(name)]
            prior = f"{{ normal = {{ mean = {value}, sd = {0.1 * value} }} }}"
            laws.append(f"parameters.{name} = {{ symbol = '{name}', unit = '{unit}', prior = {prior} }}")
        for at, coefficient, law in effects:
            laws.append(f"[[candidate.effect]]\nacts_at = '{at}'\n{coefficient} = \"{law}\"")
    chosen = ", ".join(f"{role} = '{role}.1'" for role in ROLES)
    plan = (
        "name = 'bench'\nquestion = 'how fast?'\nbase = 'rig'\n[[stage]]\nid = 'all'\ntitle = 'all'\npoints = {}\n"
        f"with = {{ {chosen} }}\n[stage.noise]\ngrowth_rate = 0.1\nangular_frequency = 1.0\npressure = 0.01\n"
    )
    files = {
        "rig.toml": "\n".join(rig),
        "campaign.csv": "point,row\na,all\n",
        "candidates/all.toml": "\n".join(laws),
        "study.toml": plan,
        "observations/observations.toml": "kind = 'virtual'\nsource = 'this file'\n",
        "observations/modes.csv": "point,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n"
        f"a,0,1,{GUESS.imag / (2 * np.pi)!r},1\n",
    }
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)


SOUND_SPEED = np.sqrt(GAMMA * R * TEMPERATURE)
DENSITY = P0 / (R * TEMPERATURE)
VISCOSITY = MU * (TEMPERATURE / 300.0) ** 0.7


def characteristic(x):
    """F of the parameters and s, in one vector of complex numbers."""
    eta, k, tau, r_u, r_d, delta, s = x
    length = LENGTH / N
    loss = eta * 4 / DIAMETER * jnp.sqrt(s * DENSITY * VISCOSITY)
    inertia = length * (s * DENSITY + loss)
    compliance = length * (s / (DENSITY * SOUND_SPEED**2) + loss * (GAMMA - 1) / (DENSITY * SOUND_SPEED) ** 2 * PR**-0.5)
    gamma = jnp.sqrt(inertia) * jnp.sqrt(compliance)
    c, sh = jnp.cosh(gamma), jnp.sinh(gamma) / gamma
    jump = jnp.zeros(N, complex).at[HEATER].set(k * jnp.exp(-s * tau))

    def step(state, segment):
        c, ps, qs, jump = segment
        p, u = state
        u = u + jump * u
        return (c * p - ps * u, c * u - qs * p), None

    z = DENSITY * SOUND_SPEED
    start = (1 - r_u, (-r_u - 1) / z[0])
    (p, u), _ = jax.lax.scan(step, start, (c, inertia * sh, compliance * sh, jump))
    reflection = -r_d * jnp.exp(-s * delta)
    return (p - z[-1] * u) - reflection * (p + z[-1] * u)


def newton(a):
    a = a.astype(complex)
    slope = jax.value_and_grad(lambda s: characteristic(jnp.append(a, s)), holomorphic=True)

    def step(carry):
        s, _ = carry
        f, df = slope(s)
        return s - f / df, abs(f / df / s)

    return jax.lax.while_loop(lambda carry: carry[1] > 1e-9, step, (jnp.asarray(GUESS), jnp.inf))[0]


def gradient(a):
    s = newton(a)
    d = jax.grad(characteristic, holomorphic=True)(jnp.append(a.astype(complex), s))
    return s, -d[:-1] / d[-1]


def hessian(a):
    s = newton(a)
    x = jnp.append(a.astype(complex), s)
    d = jax.grad(characteristic, holomorphic=True)(x)
    dd = jax.jacfwd(jax.grad(characteristic, holomorphic=True), holomorphic=True)(x)
    g = -d[:-1] / d[-1]
    cross = jnp.outer(dd[:-1, -1], g)
    return s, g, -(dd[:-1, :-1] + cross + cross.T + dd[-1, -1] * jnp.outer(g, g)) / d[-1]


def microseconds(call, rounds=15, inner=200):
    """Median and least time of a call."""
    times = []
    for _ in range(rounds):
        start = time.perf_counter()
        for _ in range(inner):
            call()
        times.append((time.perf_counter() - start) / inner * 1e6)
    return float(np.median(times)), min(times)


def main():
    with tempfile.TemporaryDirectory() as folder:
        study(Path(folder))
        model = rijke.Study(folder).run(trusted="laplace")["all"].posterior.model
    order = [NAMES.index(name) for name in model.names]
    ours = [model.solve, model.jacobian, model.hessian]
    theirs = [jax.jit(newton), jax.jit(gradient), jax.jit(hessian)]
    a = A[order]
    s, g, h = (part[0] for part in model.hessian(a))
    s_jax, g_jax, h_jax = map(np.asarray, theirs[2](jnp.asarray(A)))
    assert abs(s - s_jax) < 1e-9 * abs(s), (s, s_jax)
    assert np.allclose(g, g_jax[order], rtol=1e-8)
    assert np.allclose(h, h_jax[np.ix_(order, order)], rtol=1e-6, atol=1e-7 * abs(h).max())
    rows = {}
    for name, mine, other in zip(["eigenvalue", "gradient", "Hessian"], ours, theirs):
        on_device = jnp.asarray(A)
        rijke_us = microseconds(lambda: mine(a))
        jax_us = microseconds(lambda: jax.block_until_ready(other(on_device)))
        rows[name] = {"rijke_us": rijke_us, "jax_us": jax_us, "times": jax_us[0] / rijke_us[0]}
        print(f"{name:10}  rijke {rijke_us[0]:8.1f} us   JAX jit {jax_us[0]:8.1f} us   {rows[name]['times']:5.1f} times")
    print(json.dumps({"s": [s.real, s.imag], "jax": jax.__version__, **rows}))


if __name__ == "__main__":
    main()
