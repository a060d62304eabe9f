"""Forward models that are Python functions, fitted to data and ranked by evidence."""

from __future__ import annotations

from . import _native
from ._errors import InputError
from ._progress import told

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, Callable, Dict, List, Optional, Sequence, Union

    import numpy as np
    import pandas as pd
    import xarray as xr
    from numpy.typing import ArrayLike, NDArray

    from ._progress import Progress

    Prior = Dict[str, Dict[str, float]]


def normal(mean: float, sd: float) -> Prior:
    """A Gaussian prior."""
    return {"normal": {"mean": mean, "sd": sd}}


def log_normal(median: float, ln_sd: float) -> Prior:
    """A prior whose logarithm is Gaussian: a scale, known to a factor of about exp(ln_sd)."""
    return {"log_normal": {"median": median, "ln_sd": ln_sd}}


def uniform(low: float, high: float) -> Prior:
    """A prior that is constant between two bounds."""
    return {"uniform": {"low": low, "high": high}}


def half_normal(sd: float) -> Prior:
    """The modulus of a Gaussian number of mean zero."""
    return {"half_normal": {"sd": sd}}


class Parameter:
    """An unknown of a model: its name, its prior (:func:`normal`, :func:`log_normal` ...), unit and symbol."""

    def __init__(self, name: str, prior: Prior, unit: str = "1", symbol: str = "") -> None:
        self.name = name
        self.prior = prior
        self.unit = unit
        self.symbol = symbol or name


class Noise:
    """What is known of a standard deviation of the data.

    ``Noise()`` is floated: the most probable value is taken. ``Noise(sd)`` is known. ``Noise(sd, ln_sd)`` is inferred: its
    logarithm is Gaussian about ln(sd).
    """

    def __init__(self, sd: Optional[float] = None, ln_sd: Optional[float] = None) -> None:
        if sd is None and ln_sd is not None:
            raise InputError("ln_sd needs the median sd beside it: Noise(sd, ln_sd)")
        for name, value in (("sd", sd), ("ln_sd", ln_sd)):
            if value is not None and not 0.0 <= value < float("inf"):
                raise InputError(f"{name} is {value}, but must be a finite number that is not negative")
        self.sd = sd
        self.ln_sd = ln_sd

    def _mode(self) -> Any:
        if self.sd is None:
            return "floated"
        if self.ln_sd is None:
            return {"fixed": {"sd": self.sd}}
        return {"inferred": {"median": self.sd, "ln_sd": self.ln_sd}}


class Data:
    """Measured numbers with their noise.

    Parameters
    ----------
    values : array, shape (m,)
        In the order in which models predict them.
    noise : Noise, float or array, default floated
        Standard deviation of each number; a float is a known one for all, an array of shape (m,) one for each.
    covariance : array, shape (m, m), optional
        A known covariance that is added.
    """

    def __init__(
        self, values: ArrayLike, noise: Union[Noise, ArrayLike, None] = None, covariance: Optional[ArrayLike] = None
    ) -> None:
        import numpy as np

        if np.ma.is_masked(values):
            raise InputError("some values are masked", remedy="Leave them out, and what models predict for them.")
        if np.iscomplexobj(values):
            raise InputError("the values are complex", remedy="Give real and imaginary parts as numbers of their own.")
        self.values: NDArray[np.float64] = np.asarray(values, float)
        if self.values.ndim != 1:
            raise InputError(f"the values have the shape {self.values.shape}, but one axis is needed")
        for k in np.flatnonzero(~np.isfinite(self.values))[:1]:
            raise InputError(f"value {k} is {self.values[k]}, but must be a finite number")
        m = len(self.values)
        self.covariance = None if covariance is None else np.asarray(covariance, float)
        if self.covariance is not None and self.covariance.shape != (m, m):
            raise InputError(f"the covariance has the shape {self.covariance.shape}, but {(m, m)} is needed")
        if self.covariance is not None and not np.allclose(self.covariance, self.covariance.T, rtol=1e-9, atol=0.0):
            raise InputError("the covariance is not symmetric, or not finite")
        if noise is None:
            noise = Noise() if covariance is None else Noise(0.0)
        elif not isinstance(noise, Noise):
            sd = np.asarray(noise, float)
            if sd.ndim > 0:
                if sd.shape != (m,) or not np.all(np.isfinite(sd)) or np.any(sd <= 0.0):
                    raise InputError(f"the noise needs {m} positive numbers, one for each value")
                self.covariance = np.diag(sd**2) + (0.0 if self.covariance is None else self.covariance)
                sd = np.asarray(0.0)
            noise = Noise(float(sd))
        self.noise: Noise = noise

    def _json(self) -> str:
        import json

        m = len(self.values)
        # Numbers of independent noise are blocks of their own, which is faster.
        def block(values: Any, covariance: Any) -> Dict[str, Any]:
            return {"label": "data", "values": values, "covariance": covariance, "noise": [[0, list(range(len(values)))]]}

        if self.covariance is None:
            blocks = [block([float(value)], None) for value in self.values]
        else:
            blocks = [block(self.values.tolist(), self.covariance.ravel().tolist())]
        group = {"name": "noise", "unit": "1", "mode": self.noise._mode()}
        return json.dumps({"blocks": blocks if m else [], "groups": [group]})


class OwnModel:
    """A model that is a Python function.

    Parameters
    ----------
    name : str
    parameters : sequence of Parameter
    predict : callable
        Physical parameters, an array of shape (p,), to predicted numbers, shape (m,). It may be called from several threads. An
        ``ArithmeticError`` says that there is no answer here, but may be one nearby; any other exception ends the fit.
    jacobian : callable, optional
        Parameters to first derivatives, shape (m, p). Difference quotients of fourth order if not given.
    hessian : callable, optional
        Parameters to second derivatives, shape (m, p, p). Without it the Hessian of the cost is Gauss and Newton's.

    Functions of JAX fit as they are: ``jacobian=jax.jit(jax.jacfwd(f))``, ``hessian=jax.jit(jax.hessian(f))``, with
    ``jax_enable_x64``.
    """

    def __init__(
        self,
        name: str,
        parameters: Sequence[Parameter],
        predict: Callable[[Any], Any],
        jacobian: Optional[Callable[[Any], Any]] = None,
        hessian: Optional[Callable[[Any], Any]] = None,
    ) -> None:
        self.name = name
        self.parameters = list(parameters)
        self.predict = predict
        self.jacobian = jacobian
        self.hessian = hessian

    @property
    def parameters_json(self) -> str:
        """The parameters as the compiled part takes them."""
        import json

        return json.dumps([vars(parameter) for parameter in self.parameters])


def rank(
    models: Sequence[OwnModel],
    data: Data,
    starts: int = 4,
    importance: int = 256,
    draws: int = 1000,
    seed: int = 0,
    progress: Progress = False,
) -> Ranking:
    """Fit models to data and rank them by evidence.

    All maxima that several starts lead to count; the evidence is checked by importance sampling and other tests, whose
    warnings are in the table. Ctrl-C stops.

    Parameters
    ----------
    starts : int
        Searches from the best of 32 draws from the prior, beside the one from its centre.
    importance : int
        Calls of each model spent on the importance-sampled evidence; 0 leaves that check out.
    draws : int
        Draws from Laplace's Gaussian to keep.
    seed : int
        Of all random numbers: the same seed gives the same bits.
    progress : bool or callable
        True shows a bar in a notebook, else a line per model. A callable is given (models done, all models, name of the next).
    """
    import json

    found = json.loads(_native.rank(list(models), data._json(), starts, importance, draws, seed, told(progress, "model")))
    return Ranking(list(models), data, found)


class Ranking:
    """Models in order of decreasing posterior probability.

    Attributes
    ----------
    record : dict
        Everything that was found.
    """

    def __init__(self, models: List[OwnModel], data: Data, record: Dict[str, Any]) -> None:
        self.models = models
        self.data = data
        self.record = record

    @property
    def frame(self) -> pd.DataFrame:
        """A table, best first: name, number of parameters, ``ln_best_fit``, ``ln_occam``, ``ln_marginal`` (nats), probability,
        ln of the Bayes factor over the best, and the verdict: "trusted", or why not."""
        import pandas as pd

        rows = []
        for model in self.record["ranking"]["models"]:
            evidence = model["outcome"].get("Ok") or {}
            warnings = "; ".join(model["warnings"]) or "trusted"
            rows.append({
                "name": model["name"],
                "parameters": model["parameters"],
                **{name: evidence.get(name) for name in ("ln_best_fit", "ln_occam", "ln_marginal")},
                "probability": model["probability"],
                "ln_bayes_factor": model["ln_bayes_factor"],
                "verdict": model["outcome"].get("Err") or warnings,
            })
        return pd.DataFrame(rows)

    @property
    def xarray(self) -> xr.Dataset:
        """:attr:`frame` for xarray, over ``name``."""
        from ._table import dataset

        return dataset(self.frame, "name")

    def plot_models(self, ax: Any = None) -> Any:
        """Evidence of the models, best above; returns matplotlib's axes."""
        from ._plots import ranking

        return ranking(self, ax)

    def _found(self, name: Optional[str]) -> Dict[str, Any]:
        wanted = name or str(self.record["ranking"]["models"][0]["name"])
        for found in self.record["models"]:
            if found and found["record"]["model"] == wanted:
                return dict(found)
        known = ", ".join(model.name for model in self.models)
        raise InputError(f"no model called `{wanted}` could be fitted", None, None, f"Give one of {known}.")

    def parameters(self, name: Optional[str] = None) -> pd.DataFrame:
        """Parameters of a model, of the best one if none is named: name, symbol, unit, value, sd."""
        import pandas as pd

        return pd.DataFrame(self._found(name)["record"]["parameters"]).drop(columns="prior", errors="ignore")

    def covariance(self, name: Optional[str] = None) -> NDArray[np.float64]:
        """Posterior covariance of the physical parameters, shape (p, p)."""
        import numpy as np

        return np.array(self._found(name)["record"]["covariance"])

    def draws(self, name: Optional[str] = None) -> Dict[str, NDArray[np.float64]]:
        """Draws from Laplace's Gaussian by parameter, shape (draws,) each."""
        import numpy as np

        return {key: np.array(value[0]) for key, value in (self._found(name)["draws"] or {}).items()}

    def to_arviz(self, name: Optional[str] = None) -> Any:
        """Draws as ArviZ's ``InferenceData``, with ``observed_data`` and ``log_likelihood``; calls the model for every draw.

        With a covariance between data the log likelihood is that of each number given all others.
        """
        import arviz
        import numpy as np

        found = self._found(name)
        draws = self.draws(name)
        model = next(m for m in self.models if m.name == found["record"]["model"])
        count = len(next(iter(draws.values()))) if draws else 0
        points = np.array([draws[p.name] for p in model.parameters]).T.reshape(count, -1)
        residual = np.array([np.asarray(model.predict(a), float) - self.data.values for a in points])
        sd = found["record"]["noise"][0]["sd"]
        covariance = np.zeros((len(self.data.values),) * 2) if self.data.covariance is None else self.data.covariance
        # Of each number given the others: precision q_kk, and mean offset (Q r)_k/q_kk.
        precision = np.linalg.inv(covariance + sd**2 * np.eye(len(self.data.values)))
        q = np.diag(precision)
        ln = 0.5 * np.log(q / (2 * np.pi)) - 0.5 * (residual @ precision) ** 2 / q
        groups = {
            "posterior": {key: value[None] for key, value in draws.items()},
            "observed_data": {"data": self.data.values},
            "log_likelihood": {"data": ln[None]},
        }
        if hasattr(arviz, "InferenceData"):
            return arviz.from_dict(**groups)
        return arviz.from_dict(groups)  # ArviZ 1.0 and later

    def __repr__(self) -> str:
        words = [f"{m['name']} {m['probability'] or 0.0:.3f}" for m in self.record["ranking"]["models"]]
        return f"<rijke.Ranking: {', '.join(words)}>"

    def _repr_html_(self) -> str:
        return str(self.frame.to_html(index=False))
