"""PyMC and nutpie on the model of a study, from its values and exact gradients: what the test with the mark `samplers` runs."""

from typing import Any, Callable, Tuple

import numpy as np
import rijke
from conftest import ROOT


Energy = Callable[[Any], Tuple[float, Any]]


def problem() -> Tuple[Any, Energy]:
    """The heat release of the quarter-wave study: its model, and ln of the likelihood with its gradient. The misfit is that of the
    study."""
    stage = rijke.Study(ROOT / "examples" / "quarter-wave").run(trusted="laplace")["heat"]
    model = stage.posterior.model
    measured = stage.measured
    misfit = next(m["misfit"] for m in stage.record["models"] if m["id"] == stage.chosen)
    growth, frequency = (measured[name].to_numpy() for name in ("growth_rate", "angular_frequency"))
    sds = [np.hypot(measured[f"{name}_sd"].to_numpy(), misfit[k]) for k, name in enumerate(("growth_rate", "angular_frequency"))]

    def likelihood(values: Any) -> Tuple[float, Any]:
        try:
            s, slope = model.jacobian(values)
        except rijke.ComputationError:  # no mode near that which was measured: as good as impossible
            return -np.inf, np.zeros(len(values))
        off = [(s.real - growth) / sds[0], (s.imag - frequency) / sds[1]]
        gradient = -(off[0] / sds[0]) @ slope.real - (off[1] / sds[1]) @ slope.imag
        return float(-0.5 * (off[0] @ off[0] + off[1] @ off[1])), gradient

    return model, likelihood


def by_pymc(draws: int = 500, chains: int = 4) -> Any:
    """PyMC's NUTS; returns ArviZ's summary."""
    import arviz
    import pymc as pm
    import pytensor.tensor as pt
    from pytensor.graph.op import Op

    model, likelihood = problem()

    class Slope(Op):  # type: ignore[misc]
        itypes, otypes = [pt.dvector], [pt.dvector]

        def perform(self, node: Any, inputs: Any, outputs: Any) -> None:
            outputs[0][0] = likelihood(inputs[0])[1]

    class LogLikelihood(Op):  # type: ignore[misc]
        itypes, otypes = [pt.dvector], [pt.dscalar]

        def perform(self, node: Any, inputs: Any, outputs: Any) -> None:
            outputs[0][0] = np.asarray(likelihood(inputs[0])[0])

        def grad(self, inputs: Any, output_grads: Any) -> Any:
            return [output_grads[0] * Slope()(inputs[0])]

        def pullback(self, inputs: Any, outputs: Any, cotangents: Any) -> Any:
            return self.grad(inputs, cotangents)

    with pm.Model():
        priors = {name: prior["normal"] for name, prior in model.priors.items()}
        values = [pm.Normal(name, prior["mean"], prior["sd"]) for name, prior in priors.items()]
        pm.Potential("likelihood", LogLikelihood()(pt.stack(values)))
        start = dict(zip(model.names, model.medians))
        trace = pm.sample(
            draws, tune=500, chains=chains, cores=1, random_seed=1, initvals=start, init="adapt_diag", progressbar=False,
            compute_convergence_checks=False,
        )
    return arviz.summary(trace, round_to=6)


def by_nutpie(draws: int = 500, chains: int = 4) -> Any:
    """nutpie's NUTS; returns ArviZ's summary."""
    import arviz
    import nutpie.compiled_pyfunc

    model, likelihood = problem()
    priors = [prior["normal"] for prior in model.priors.values()]
    mean, sd = np.array([p["mean"] for p in priors]), np.array([p["sd"] for p in priors])

    def density(z: Any) -> Tuple[float, Any]:
        # z: standard deviations of the prior from its mean.
        value, gradient = likelihood(mean + sd * z)
        return value - 0.5 * float(z @ z), gradient * sd - z

    compiled = nutpie.compiled_pyfunc.from_pyfunc(
        ndim=len(mean),
        make_logp_fn=lambda: density,
        make_expand_fn=lambda *_: lambda z: {"values": mean + sd * z},
        expanded_dtypes=[np.dtype("float64")],
        expanded_shapes=[(len(mean),)],
        expanded_names=["values"],
    )
    trace = nutpie.sample(compiled, draws=draws, tune=500, chains=chains, cores=1, seed=1, progress_bar=False)
    return arviz.summary(trace, round_to=6)
