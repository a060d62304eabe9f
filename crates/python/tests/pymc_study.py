"""PyMC and nutpie on the model of a study, from its values and exact gradients: what the test with the mark `samplers` runs."""

from typing import Any

import numpy as np
import rijke
from conftest import ROOT


def sample(draws: int = 1000, chains: int = 4) -> Any:
    """Draws of the heat release of the quarter-wave study; returns ArviZ's summary. The misfit is that of the study."""
    import arviz
    import nutpie
    import pymc as pm
    import pytensor.tensor as pt
    from pytensor.graph.op import Op

    stage = rijke.Study(ROOT / "examples" / "quarter-wave").run()["heat"]
    model = stage.posterior.model
    measured = stage.measured
    misfit = next(m["misfit"] for m in stage.record["models"] if m["id"] == stage.chosen)
    sd = [np.hypot(measured[f"{name}_sd"], misfit[k]) for k, name in enumerate(("growth_rate", "angular_frequency"))]

    def energy(values: Any) -> Any:
        s, slope = model.jacobian(values)
        off = [(s.real - measured["growth_rate"]) / sd[0], (s.imag - measured["angular_frequency"]) / sd[1]]
        gradient = -(off[0] / sd[0]) @ slope.real - (off[1] / sd[1]) @ slope.imag
        return -0.5 * (off[0] @ off[0] + off[1] @ off[1]), np.asarray(gradient)

    class Slope(Op):  # type: ignore[misc]
        itypes, otypes = [pt.dvector], [pt.dvector]

        def perform(self, node: Any, inputs: Any, outputs: Any) -> None:
            outputs[0][0] = energy(inputs[0])[1]

    class LogLikelihood(Op):  # type: ignore[misc]
        itypes, otypes = [pt.dvector], [pt.dscalar]

        def perform(self, node: Any, inputs: Any, outputs: Any) -> None:
            outputs[0][0] = np.asarray(energy(inputs[0])[0])

        def grad(self, inputs: Any, output_grads: Any) -> Any:
            return [output_grads[0] * Slope()(inputs[0])]

    with pm.Model() as bayes:
        priors = [prior["normal"] for prior in model.priors.values()]
        values = [
            pm.Normal(name, prior["mean"], prior["sd"]) for name, prior in zip(model.names, priors)
        ]
        pm.Potential("likelihood", LogLikelihood()(pt.stack(values)))
    trace = nutpie.sample(nutpie.compile_pymc_model(bayes), draws=draws, chains=chains, seed=1, progress_bar=False)
    return arviz.summary(trace, round_to=6)
