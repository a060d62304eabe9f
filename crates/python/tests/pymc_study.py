"""PyMC and nutpie on the model of a study, from its values and exact gradients: what the test with the mark `samplers` runs.

`python crates/python/tests/pymc_study.py pymc|nutpie [FOLDER STAGE ON]` prints what is in docs/records/python.md.
"""

import sys
import time
from pathlib import Path
from typing import Any, Callable, Tuple

import numpy as np
import rijke

ROOT = Path(__file__).resolve().parents[3]

#: ln of a density and its gradient.
Density = Callable[[Any], Tuple[float, Any]]


def problem(folder: Any = ROOT / "examples" / "quarter-wave", stage: str = "heat", on: str = "gauze") -> Tuple[Any, Any, Any, Density]:
    """The chosen model of a stage: its posterior, the matrix L of z -> mean + L z, and ln of the density of z with its gradient.

    The likelihood is that of growth rates and frequencies with the measured errors and the misfit of the stage, and with what installations
    differ by, to first order at Laplace's mean. The prior is the posterior of the stage `on`, and the Gaussian that the candidates state of
    parameters that are new. L L' is Laplace's covariance: in z
    all directions have about the width one, which a sampler would else have to learn, while trees of a thousand steps miss the time.
    """
    results = rijke.Study(folder).run(trusted="laplace", until=stage)
    found, before = results[stage], results[on].posterior
    posterior = found.posterior
    model, own = posterior.model, len(posterior.model.names)
    mean = posterior.mean[:own]
    lower = np.linalg.cholesky(posterior.covariance[:own, :own])
    normals = [model.priors[name]["normal"] for name in model.names]
    centre, known = np.array([p["mean"] for p in normals]), np.diag([p["sd"] ** 2 for p in normals])
    shared = [(k, before.names.index(name)) for k, name in enumerate(model.names) if name in before.names]
    here, there = (list(places) for places in zip(*shared))
    centre[here], known[np.ix_(here, here)] = before.mean[there], before.covariance[np.ix_(there, there)]
    certain = np.linalg.inv(known)
    measured = found.measured
    misfit = next(m["misfit"] for m in found.record["models"] if m["id"] == found.chosen)
    names = ("growth_rate", "angular_frequency")
    values: Any = np.concatenate([measured[name].to_numpy() for name in names])
    variance: Any = np.concatenate([measured[f"{name}_sd"].to_numpy() ** 2 + misfit[k] ** 2 for k, name in enumerate(names)])
    covariance = np.diag(variance)
    slope = model.jacobian(mean)[1]
    count = len(measured)
    for named, sd in zip(posterior.noise["name"], posterior.noise["sd"]):
        name, _, kind = str(named).partition(", ")
        if kind == "between installations" and name in model.names:
            k = model.names.index(name)
            # Each point was an installation of its own.
            effect = sd * np.array([np.diag(slope[:, k].real), np.diag(slope[:, k].imag)]).reshape(2 * count, count)
            covariance = covariance + effect @ effect.T
    precision = np.linalg.inv(covariance)

    def density(z: Any) -> Tuple[float, Any]:
        at = mean + lower @ z
        try:
            s, slope = model.jacobian(at)
        except rijke.ComputationError:  # no mode near that which was measured: as good as impossible
            return -np.inf, np.zeros(own)
        off = precision @ (residual := np.concatenate([s.real, s.imag]) - values)
        far = certain @ (at - centre)
        gradient = np.concatenate([slope.real, slope.imag]).T @ off + far
        return float(-0.5 * (residual @ off + far @ (at - centre))), -(lower.T @ gradient)

    return posterior, lower, mean, density


def by_pymc(of: Any, draws: int = 500, chains: int = 4, tune: int = 500) -> Any:
    """PyMC's NUTS; returns the draws as ArviZ holds them."""
    import pymc as pm
    import pytensor.tensor as pt
    from pytensor.graph.op import Op

    _, lower, mean, density = of

    class LogDensity(Op):  # type: ignore[misc]
        """Value and gradient from one call of the model."""

        itypes, otypes = [pt.dvector], [pt.dscalar, pt.dvector]

        def perform(self, node: Any, inputs: Any, outputs: Any) -> None:
            value, slope = density(inputs[0])
            outputs[0][0], outputs[1][0] = np.asarray(value), slope

        def grad(self, inputs: Any, output_grads: Any) -> Any:
            return [output_grads[0] * self(inputs[0])[1]]

        def pullback(self, inputs: Any, outputs: Any, cotangents: Any) -> Any:
            return self.grad(inputs, cotangents)

    with pm.Model():
        z = pm.Flat("z", shape=len(mean))
        pm.Potential("density", LogDensity()(z)[0])
        pm.Deterministic("values", mean + pt.dot(lower, z))
        return pm.sample(
            draws, tune=tune, chains=chains, cores=1, random_seed=1, initvals={"z": np.zeros(len(mean))}, init="adapt_diag",
            progressbar=False, compute_convergence_checks=False,
        )


def by_nutpie(of: Any, draws: int = 500, chains: int = 4, tune: int = 500) -> Any:
    """nutpie's NUTS; returns the draws as ArviZ holds them."""
    import nutpie.compiled_pyfunc

    _, lower, mean, density = of
    compiled = nutpie.compiled_pyfunc.from_pyfunc(
        ndim=len(mean),
        make_logp_fn=lambda: density,
        make_expand_fn=lambda *_: lambda z: {"values": mean + lower @ z},
        expanded_dtypes=[np.dtype("float64")],
        expanded_shapes=[(len(mean),)],
        expanded_names=["values"],
    )
    return nutpie.sample(compiled, draws=draws, tune=tune, chains=chains, cores=1, seed=1, progress_bar=False)


SAMPLERS = {"pymc": by_pymc, "nutpie": by_nutpie}


def summary(sampler: str, of: Any) -> Any:
    """ArviZ's summary of what a sampler drew, a row per parameter, with Laplace's mean and sd beside it."""
    import arviz

    posterior, lower, mean, _ = of
    table = arviz.summary(SAMPLERS[sampler](of), var_names=["values"], kind="all", round_to=12)
    table.index = posterior.model.names
    return table.assign(laplace=mean, laplace_sd=np.sqrt(np.diag(lower @ lower.T)))


if __name__ == "__main__":
    of = problem(*sys.argv[2:])
    calls = [0]
    inner = of[3]

    def counted(z: Any) -> Any:
        calls[0] += 1
        return inner(z)

    start = time.perf_counter()
    table = summary(sys.argv[1], (*of[:3], counted))
    spent = time.perf_counter() - start
    print(table[["mean", "sd", "laplace", "laplace_sd", "ess_bulk", "ess_tail", "r_hat"]].to_string())
    print(f"{spent:.1f} s, {calls[0]} calls, {1e3 * spent / calls[0]:.2f} ms each")
