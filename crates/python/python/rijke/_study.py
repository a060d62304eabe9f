"""A study: a folder that says rig, campaign, candidates, observations and stages (``docs/study-folder.md``)."""

from __future__ import annotations

import os

from . import _native
from ._errors import InputError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, Callable, Dict, Iterator, List, Optional, Tuple, Union

    import numpy as np
    import pandas as pd
    from numpy.typing import ArrayLike, NDArray

    #: Called before each stage with the number of stages done, how many there are, and the title of the next.
    Progress = Callable[[int, int, str], None]


class Study:
    """A study folder, read and checked.

    Parameters
    ----------
    folder : path
        The folder; nothing in it is changed.

    Raises
    ------
    InputError
        With file, line and remedy.
    """

    def __init__(self, folder: Union[str, "os.PathLike[str]"]) -> None:
        import json

        self.folder = os.fspath(folder)
        self._native = _native.Study(self.folder)
        self._summary: Dict[str, Any] = json.loads(self._native.summary())

    @property
    def name(self) -> str:
        """What the study is called."""
        return str(self._summary["name"])

    @property
    def question(self) -> str:
        """The question that it answers."""
        return str(self._summary["question"])

    @property
    def stages(self) -> Dict[str, str]:
        """Titles of the stages by name, in their order."""
        return dict(self._summary["stages"])

    @property
    def points(self) -> pd.DataFrame:
        """The operating points: a row each, factors in SI units, NaN where a factor has no value."""
        import pandas as pd

        rows = self._summary["points"]
        frame = pd.DataFrame({key: [row[key] for row in rows] for key in ("point", "row", "installation", "day")})
        for k, (name, _) in enumerate(self._summary["factors"]):
            frame[name] = pd.array([row["factors"][k] for row in rows], dtype="Float64").to_numpy(float, na_value=float("nan"))
        return frame

    def run(
        self, progress: Union[bool, Progress] = False, trusted: str = "checked", error: float = 0.1
    ) -> Results:
        """Train and rank the models of every stage, in order, as the program ``rijke run`` does.

        Ctrl-C stops between stages; other threads of Python go on meanwhile.

        Parameters
        ----------
        progress : bool or callable
            True prints a line per stage. A callable is given (stages done, all stages, title of the next).
        trusted : {"checked", "laplace", "nested"}
            How far evidence is checked: by importance sampling and other starts, as ``rijke run`` does; not at all, as
            ``rijke run --one-start``; by nested sampling too.
        error : float
            Statistical error of nested sampling, nats.
        """
        import json

        call: Progress = _print if progress is True else (progress or _silent)
        run = self._native.start(trusted, error)
        results = Results(self)
        stages = list(self.stages.items())
        for done, (_, title) in enumerate(stages):
            call(done, len(stages), title)
            text = run.next_stage()
            if text is None:
                break
            stage = Stage(self, run, json.loads(text))
            results.stages[stage.id] = stage
        call(len(stages), len(stages), "")
        return results

    rank = run

    def __reduce__(self) -> Any:
        return Study, (self.folder,)

    def __repr__(self) -> str:
        return f"<rijke.Study {self.name!r}: {len(self._summary['points'])} operating points, {len(self.stages)} stages>"

    def _repr_html_(self) -> str:
        from ._html import escape, table

        head = f"<b>{escape(self.name)}</b>: {escape(self.question)}"
        return head + table(["stage", "title"], [[*item] for item in self.stages.items()])


class Results:
    """The stages of a study that have run, by name: ``results["heat-release"]``."""

    def __init__(self, study: Study) -> None:
        self.study = study
        self.stages: Dict[str, Stage] = {}

    def __getitem__(self, id: str) -> Stage:
        if id not in self.stages:
            known = ", ".join(self.stages)
            raise InputError(f"no stage called `{id}` has run", self.study.folder, None, f"Give one of {known}.")
        return self.stages[id]

    def __iter__(self) -> Iterator[Stage]:
        return iter(self.stages.values())

    def __len__(self) -> int:
        return len(self.stages)

    @property
    def frame(self) -> pd.DataFrame:
        """The models of all stages: a row each, see :attr:`Stage.models`."""
        import pandas as pd

        frames = [stage.models.assign(stage=stage.id) for stage in self]
        return pd.concat(frames, ignore_index=True) if frames else pd.DataFrame()

    def _repr_html_(self) -> str:
        return "".join(stage._repr_html_() for stage in self)


class Stage:
    """What one stage of a study found.

    Attributes
    ----------
    record : dict
        Everything, as ``rijke run`` writes it to ``results/numbers``.
    """

    def __init__(self, study: Study, run: _native.Run, record: Dict[str, Any]) -> None:
        self.study = study
        self.record = record
        self._run = run

    @property
    def id(self) -> str:
        """Name of the stage."""
        return str(self.record["id"])

    @property
    def title(self) -> str:
        """What it is called."""
        return str(self.record["title"])

    @property
    def winner(self) -> str:
        """The model with the most evidence."""
        return str(self.record["winner"])

    @property
    def chosen(self) -> str:
        """The model that goes on: the first that none beats decisively."""
        return str(self.record["chosen"])

    @property
    def models(self) -> pd.DataFrame:
        """The models, best first: ``id``, ``label``, ``ln_best_fit``, ``ln_occam``, ``ln_marginal`` (nats, in total), ``below``
        (nats below the best), ``chosen``, and ``remark``: warnings, or why there is no evidence."""
        import pandas as pd

        names = ["ln_best_fit", "ln_occam", "ln_marginal", "observations"]
        rows = []
        for model in self.record["models"]:
            evidence = model["evidence"] or {}
            row = {"id": model["id"], "label": model["label"], **{name: evidence.get(name) for name in names}}
            rows.append({**row, "chosen": model["id"] == self.chosen, "remark": model["remark"]})
        frame = pd.DataFrame(rows)
        frame[names[:3]] = frame[names[:3]].astype(float)
        frame.insert(5, "below", frame["ln_marginal"] - frame["ln_marginal"].max())
        return frame.sort_values("ln_marginal", ascending=False, ignore_index=True)

    def parameters(self, model: Optional[str] = None) -> pd.DataFrame:
        """Parameters of a model, of the chosen one if none is named: name, symbol, unit, value, sd, and how many prior
        standard deviations the value lies from the prior mean."""
        import pandas as pd

        wanted = model or self.chosen
        found = [m for m in self.record["models"] if m["id"] == wanted]
        if not found:
            known = ", ".join(m["id"] for m in self.record["models"])
            raise InputError(f"stage `{self.id}` has no model `{wanted}`", self.study.folder, None, f"Give one of {known}.")
        return pd.DataFrame(found[0]["parameters"])

    @property
    def measured(self) -> pd.DataFrame:
        """The observations that trained: point, mode, growth rate (1/s) and angular frequency (rad/s) with their sd."""
        import pandas as pd

        rows = self.record["measured"]
        frame = pd.DataFrame({"point": [row["point"] for row in rows], "mode": [row["mode"] for row in rows]})
        for name in ("growth_rate", "angular_frequency"):
            pairs = [row[name] or (float("nan"), float("nan")) for row in rows]
            frame[name], frame[f"{name}_sd"] = [p[0] for p in pairs], [p[1] for p in pairs]
        return frame

    @property
    def posterior(self) -> Posterior:
        """What is known of the parameters of the chosen model."""
        return Posterior(self, self._run.posterior(self.id))

    @property
    def predictions(self) -> pd.DataFrame:
        """What the chosen model predicts of a new measurement in a new installation at every point that was observed: growth
        rate (1/s) and angular frequency (rad/s) with sd, and beside them what was measured."""
        import pandas as pd

        frame = pd.DataFrame(self._run.for_predictions(self.id).predictions())
        measured = self.measured
        for name in ("growth_rate", "angular_frequency"):
            frame[f"measured_{name}"] = measured[name]
        return frame

    def plot_models(self, ax: Any = None) -> Any:
        """Evidence of the models; returns matplotlib's axes."""
        from ._plots import stage

        return stage(self, ax)

    def plot_predictions(self, quantity: str = "growth_rate", ax: Any = None) -> Any:
        """Predicted against measured ``growth_rate`` or ``angular_frequency``; returns matplotlib's axes."""
        from ._plots import predictions

        return predictions(self, quantity, ax)

    def __repr__(self) -> str:
        return f"<rijke.Stage {self.id!r}: {len(self.record['models'])} models, {self.chosen!r} goes on>"

    def _repr_html_(self) -> str:
        from ._html import escape, table

        rows = [
            [m.label, m.id, f"{m.ln_marginal:.1f}", f"{m.below:.1f}", "goes on" if m.chosen else ""]
            for m in self.models.itertuples()
        ]
        head = ["model", "id", "ln evidence / nats", "below the best", ""]
        return f"<b>{escape(self.title)}</b>" + table(head, rows)


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
        and ``observed_data`` (growth rate in 1/s, angular frequency in rad/s), ``log_likelihood`` (of both, by observation,
        independent given the parameters, with measured and floated variances; relative pressures and errors that several
        observations share are left out), ``constant_data`` (standard deviations).
        """
        import arviz
        import numpy as np

        sample = self.draws(chains * draws, seed).reshape(chains, draws, -1)
        own = self._native.own
        s = self.model.solve(sample[..., :own])
        measured = self.stage.measured
        misfit = next(m["misfit"] for m in self.stage.record["models"] if m["id"] == self.stage.chosen)
        predictive, observed, constant, ln = {}, {}, {}, {}
        for k, (name, part) in enumerate([("growth_rate", s.real), ("angular_frequency", s.imag)]):
            value = measured[name].to_numpy()
            there = np.isfinite(value)
            sd = np.hypot(measured[f"{name}_sd"].to_numpy(), misfit[k])[there]
            predictive[name], observed[name] = part[..., there], value[there]
            constant[f"{name}_sd"] = sd
            ln[name] = -0.5 * ((part[..., there] - value[there]) / sd) ** 2 - np.log(sd * np.sqrt(2 * np.pi))
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


def _silent(done: int, count: int, title: str) -> None:
    pass


def _print(done: int, count: int, title: str) -> None:
    if title:
        print(f"stage {done + 1} of {count}: {title}", flush=True)
