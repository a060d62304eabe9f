"""What a stage of a study found of its parameters, for NumPy and ArviZ."""

from __future__ import annotations

from . import _native

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, Dict, List, Tuple

    import numpy as np
    import pandas as pd
    from numpy.typing import ArrayLike, NDArray

    from ._study import Stage


class Posterior:
    """What is known of the parameters of a model: a Gaussian in their working coordinates, by Laplace's method."""

    def __init__(self, stage: Stage, native: _native.Posterior) -> None:
        self.stage = stage
        self._native = native

    @property
    def names(self) -> List[str]:
        """Names of the parameters; after those of the model come errors of base states and channels, if any."""
        return [name for name, _, _ in self._native.parameters]

    @property
    def mean(self) -> NDArray[np.float64]:
        """Most probable physical values, shape (p,)."""
        return self._native.mean

    @property
    def covariance(self) -> NDArray[np.float64]:
        """Covariance of the physical values, to first order; shape (p, p)."""
        return self._native.covariance

    @property
    def frame(self) -> pd.DataFrame:
        """A table: name, symbol, unit, value, sd."""
        import numpy as np
        import pandas as pd

        frame = pd.DataFrame(self._native.parameters, columns=["name", "symbol", "unit"])
        frame["value"], frame["sd"] = self.mean, np.sqrt(np.diag(self.covariance))
        return frame

    @property
    def noise(self) -> pd.DataFrame:
        """Standard deviations of the misfit: name, unit, sd, and whether the data chose it."""
        import pandas as pd

        return pd.DataFrame(self._native.noise, columns=["name", "unit", "sd", "floats"])

    def draws(self, count: int = 1000, seed: int = 0) -> NDArray[np.float64]:
        """Independent draws of the physical parameters, shape (count, p)."""
        import numpy as np

        xi = np.random.default_rng(seed).standard_normal((count, len(self.names)))
        return self._native.points(xi)

    @property
    def model(self) -> Model:
        """The model of the observations as a function of its parameters, with derivatives."""
        return Model(self._native.model())

    def to_arviz(self, draws: int = 1000, chains: int = 4, seed: int = 0) -> Any:
        """Draws as ArviZ's ``InferenceData``, for ``arviz.summary``, ``plot_pair``, ``loo``.

        Groups: ``posterior`` (independent draws from Laplace's Gaussian, the method of the study), ``posterior_predictive``
        and ``observed_data`` (growth rate in 1/s, angular frequency in rad/s), ``constant_data`` (standard deviations), and
        ``log_likelihood``: of each growth rate, angular frequency and relative pressure given all other data and the parameters, so that
        errors which data share count. It takes the prediction as linear about the fit and the noise as fitted.
        """
        import arviz
        import numpy as np

        sample = self.draws(chains * draws, seed)
        ln_densities = self._native.ln_densities(sample).reshape(chains, draws, -1)
        sample = sample.reshape(chains, draws, -1)
        s = self.model.solve(sample[..., : self._native.own])
        measured = self.stage.measured
        misfit = next(m["misfit"] for m in self.stage.record["models"] if m["id"] == self.stage.chosen)
        predictive, observed, constant, ln = {}, {}, {}, {}
        place, row = np.array(self._native.data).T
        for k, (name, part) in enumerate([("growth_rate", s.real), ("angular_frequency", s.imag)]):
            value = measured[name].to_numpy()
            there = np.isfinite(value)
            predictive[name], observed[name] = part[..., there], value[there]
            constant[f"{name}_sd"] = np.hypot(measured[f"{name}_sd"].to_numpy(), misfit[k])[there]
            own = np.flatnonzero(row == k)
            ln[name] = ln_densities[..., own[np.argsort(place[own])]]
        pressures = np.flatnonzero(row > 1)
        if pressures.size:
            ln["relative_pressure"] = ln_densities[..., pressures]
        groups = {
            "posterior": {name: sample[..., k] for k, name in enumerate(self.names)},
            "posterior_predictive": predictive,
            "observed_data": observed,
            "constant_data": constant,
            "log_likelihood": ln,
        }
        if hasattr(arviz, "InferenceData"):
            return arviz.from_dict(**groups)
        return arviz.from_dict(groups)  # ArviZ 1.0 and later

    def __repr__(self) -> str:
        return f"<rijke.Posterior of {self.stage.chosen!r}: {', '.join(self.names)}>"

    def _repr_html_(self) -> str:
        return str(self.frame.to_html(index=False))


class Model:
    """The eigenvalues of a study's observations as a function of parameters, with exact first and second derivatives.

    Values may carry any leading axes: ``(..., p)`` in, ``(..., n)`` out, in parallel. n observations, p parameters.
    """

    def __init__(self, native: _native.Model) -> None:
        import json

        self._native = native
        self._parameters: List[Dict[str, Any]] = json.loads(native.parameters())

    @property
    def names(self) -> List[str]:
        """Names of the parameters."""
        return [str(p["name"]) for p in self._parameters]

    @property
    def priors(self) -> Dict[str, Any]:
        """Each parameter's own prior, as its candidate states it. Earlier stages may know more of it."""
        return {str(p["name"]): p["prior"] for p in self._parameters}

    @property
    def medians(self) -> NDArray[np.float64]:
        """Medians of the priors, shape (p,)."""
        return self._native.medians

    @property
    def points(self) -> List[str]:
        """Operating point of every observation."""
        return [point for point, _ in self._native.points]

    @property
    def measured(self) -> NDArray[np.complex128]:
        """Growth rate + i angular frequency that were measured, shape (n,); NaN where they were not."""
        return self._native.measured()

    def solve(self, values: ArrayLike) -> NDArray[np.complex128]:
        """s of every observation, 1/s and rad/s: (..., p) -> (..., n)."""
        return self._native.solve(values, 0)[0]

    def jacobian(self, values: ArrayLike) -> Tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        """s and its first derivatives: (..., p) -> (..., n), (..., n, p)."""
        s, slope = self._native.solve(values, 1)
        return s, slope

    def hessian(
        self, values: ArrayLike
    ) -> Tuple[NDArray[np.complex128], NDArray[np.complex128], NDArray[np.complex128]]:
        """s, its first and its second derivatives: (..., p) -> (..., n), (..., n, p), (..., n, p, p)."""
        s, slope, curvature = self._native.solve(values, 2)
        return s, slope, curvature

    def __repr__(self) -> str:
        return f"<rijke.Model of {len(self.points)} observations: {', '.join(self.names)}>"
