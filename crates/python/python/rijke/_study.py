"""A study: a folder that says rig, campaign, candidates, observations and stages (``docs/study-folder.md``)."""

from __future__ import annotations

import os

from . import _native
from ._errors import InputError
from ._posterior import Posterior
from ._progress import told

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, Dict, Iterator, List, Mapping, Optional, Sequence, Union

    import pandas as pd
    import xarray as xr

    from ._progress import Progress

    Points = Union[Sequence[Mapping[str, float]], pd.DataFrame, None]


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
        self._results: Optional[Results] = None

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

    def check(self, sd: Sequence[float] = (0.1, 1.0, 1e-3), ambient: float = 293.15) -> pd.DataFrame:
        """What the campaign can tell of the parameters, before or after anything is measured, as ``rijke check`` says it.

        Parameters
        ----------
        sd : three numbers
            Noise of one operating point, model error included: growth rate (1/s), angular frequency (rad/s), relative pressure.
        ambient : float
            Temperature where the campaign states none, K.

        Returns
        -------
        pandas.DataFrame
            A row per stage, model and parameter. ``width``: the posterior sd to first order over that of the prior.
            ``not_identified``: combinations of parameters that keep more than 0.9 of it. ``lost``: points without a mode at
            the centre of the priors.
        """
        import json

        import pandas as pd

        beside = [os.path.join(self.folder, "observations", name) for name in ("observations.toml", "modes.csv", "pings.csv")]
        found = json.loads(self._native.check(any(map(os.path.isfile, beside)), list(map(float, sd)), ambient))
        rows = [
            {
                "stage": stage["id"], "model": model["id"], "parameter": name, "width": width,
                "not_identified": "; ".join(words for words, _ in model["unidentified"]), "lost": ", ".join(model["lost"]),
            }
            for stage in found["stages"] for model in stage["models"] for name, width in model["widths"]
        ]
        return pd.DataFrame(rows, columns=["stage", "model", "parameter", "width", "not_identified", "lost"])

    def process(self, force: bool = False) -> pd.DataFrame:
        """Turn the records of the study into ``observations``, as ``rijke process`` does; needs that program.

        Returns a row per operating point: ``point``, ``pings``, ``clicks``, growth rate (1/s) and angular frequency (rad/s) with
        sd. Records of random noise or blows give no such rows. ``force`` replaces what was processed before.
        """
        import pandas as pd

        from ._program import call

        found = call(["process", self.folder, "--out", os.path.join(self.folder, "observations"), *["--force"] * force])
        rows = []
        for point in found.get("points", []):
            row = {key: point[key] for key in ("point", "pings", "clicks")}
            for name in ("growth_rate", "angular_frequency"):
                row[name], row[f"{name}_sd"] = point[name] or (float("nan"), float("nan"))
            rows.append(row)
        return pd.DataFrame(rows)

    def flow(self, force: bool = False) -> Dict[str, Any]:
        """Infer the gas flow along the tube from clicks or readings into ``base``, as ``rijke flow`` does; needs that program.

        Returns what it writes to ``flow.json``: per heater position the unknowns with 2 sd, and velocities (m/s) and profiles.
        """
        from ._program import call

        return dict(call(["flow", self.folder, "--out", os.path.join(self.folder, "base"), *["--force"] * force]))

    def predict(self, at: Points = None, stage: Optional[str] = None) -> pd.DataFrame:
        """:meth:`Stage.predict` of the last stage that was run, or of the one named; runs the study if none was."""
        return self._stage(stage).predict(at)

    def next(self, stage: Optional[str] = None, **wishes: Any) -> Suggestions:
        """:meth:`Stage.next` of the last stage that was run, or of the one named; runs the study if none was."""
        return self._stage(stage).next(**wishes)

    def _stage(self, id: Optional[str]) -> Stage:
        results = self._results or self.run()
        return results[id or list(results.stages)[-1]]

    def run(
        self, progress: Progress = False, trusted: str = "checked", error: float = 0.1, until: Optional[str] = None
    ) -> Results:
        """Train and rank the models of every stage, in order, as the program ``rijke run`` does.

        Ctrl-C stops before the next model; other threads of Python go on meanwhile.

        Parameters
        ----------
        progress : bool or callable
            True shows a bar in a notebook, else a line per stage. A callable is given (stages done, all stages, title of the next).
        trusted : {"checked", "laplace", "nested"}
            How far evidence is checked: by importance sampling and other starts, as ``rijke run`` does; not at all, as
            ``rijke run --one-start``; by nested sampling too.
        error : float
            Statistical error of nested sampling, nats.
        until : str, optional
            The last stage to run, as ``rijke rank --until`` takes it.
        """
        import json

        if until is not None and until not in self.stages:
            remedy = f"Give one of {', '.join(self.stages)}."
            raise InputError(f"there is no stage called `{until}`", self.folder, None, remedy)
        call = told(progress, "stage")
        run = self._native.start(trusted, error, until)
        results = Results(self)
        stages = list(self.stages.items())
        stages = stages[: list(self.stages).index(until) + 1] if until else stages
        for done, (_, title) in enumerate(stages):
            call(done, len(stages), title)
            text = run.next_stage()
            if text is None:
                break
            stage = Stage(self, run, json.loads(text))
            results.stages[stage.id] = stage
        self._results = results
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

    @property
    def xarray(self) -> xr.Dataset:
        """The same for xarray: over ``model``, which is "stage: id", with ``stage`` and ``id`` as variables."""
        from ._table import dataset

        frame = self.frame
        return dataset(frame.assign(model=frame["stage"] + ": " + frame["id"]), "model")

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

    @property
    def xarray(self) -> xr.Dataset:
        """:attr:`predictions` beside what was measured, for xarray: over ``observation``, with ``point`` and ``mode``."""
        from ._table import dataset

        measured = self.measured.add_prefix("measured_")
        columns = [name for name in measured if str(name).endswith("_sd")]
        return dataset(self.predictions.join(measured[columns]), "observation")

    def predict(self, at: Points = None) -> pd.DataFrame:
        """What the model that goes on says of operating points, measured or not, as ``rijke predict`` does.

        Parameters
        ----------
        at : sequence of dict, or DataFrame, optional
            Values of factors, of ``T_amb`` and of ``T_amb_sd`` in SI units, a dict or row per point; what is left out is that of the
            nearest point of the stage. The error of T_amb of what is no point of the campaign is its own. By default every point of the stage.

        Returns
        -------
        pandas.DataFrame
            A row per point and mode: growth rate (1/s) and angular frequency (rad/s), each with the sd of a new measurement in a
            new installation (``_sd``) and that of the model alone (``_model_sd``), ``probability_of_instability`` (with the latter and the misfit of
            growth rates that the stage found), and the same
            ``averaged_`` over the models that the evidence leaves open, where it leaves any. Points of which nothing can be said
            are in ``frame.attrs["left_out"]`` with the reason, and what the program remarks on predictions is in
            ``frame.attrs["doubts"]``.
        """
        import json

        import pandas as pd

        found = json.loads(self._run.forecast(self.id, _points(at)))
        names = [name for name, _ in self.study._summary["factors"]]

        def numbers(of: Dict[str, Any], prefix: str = "") -> Dict[str, float]:
            row = {}
            for name in ("growth_rate", "angular_frequency"):
                for word, value in zip(("", "_sd", "_model_sd"), of[name]):
                    row[f"{prefix}{name}{word}"] = value
            return {**row, f"{prefix}probability_of_instability": of["unstable"]}

        rows = []
        for one in found["forecasts"]:
            row = {"point": one["point"], "mode": one["mode"], **dict(zip(names, one["factors"])), **numbers(one)}
            row.update(numbers(one["averaged"], "averaged_") if one["averaged"] else {})
            rows.append(row)
        frame = pd.DataFrame(rows)
        frame[names] = frame[names].astype(float)
        frame.attrs["doubts"] = found["doubts"]
        frame.attrs["left_out"] = {point: why for point, why in found["left_out"]}
        return frame

    def next(
        self,
        points: int = 3,
        at: Points = None,
        about: Optional[Mapping[str, float]] = None,
        models: bool = False,
        pressures: bool = True,
    ) -> Suggestions:
        """What to measure next, as ``rijke next`` says it: information in nats, to first order.

        Parameters
        ----------
        points : int
            How many visits to plan.
        at : sequence of dict, or DataFrame, optional
            Points that may be measured, as in :meth:`predict`; by default those of the stage.
        about : dict, optional
            Plan for the growth rate at this point, which is not to be measured.
        models : bool
            Plan to tell the model from its rival.
        pressures : bool
            Whether relative pressures are measured too, if they trained the model.
        """
        import json

        wanted = None if about is None else _points([about])[0]
        found = self._run.suggest(self.id, _points(at), wanted, models, points, pressures)
        return Suggestions(self, json.loads(found))

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


class Suggestions:
    """What to measure next.

    Attributes
    ----------
    record : dict
        Everything, as ``rijke next --json`` prints it.
    """

    def __init__(self, stage: Stage, record: Dict[str, Any]) -> None:
        self.stage = stage
        self.record = record

    @property
    def frame(self) -> pd.DataFrame:
        """Possible points, the most nats per hour first: ``point``, factors (SI), ``repeat``, ``hours``, ``parameters``,
        ``which`` of several open models is right, ``quantity``, and ``nats``, which count for the aim."""
        import pandas as pd

        names = [name for name, _ in self.stage.study._summary["factors"]]
        keys = ("repeat", "hours", "parameters", "which", "quantity", "nats")
        rows = [{"point": p["point"], **dict(zip(names, p["factors"])), **{k: p[k] for k in keys}} for p in self.record["points"]]
        return pd.DataFrame(rows)

    @property
    def plan(self) -> pd.DataFrame:
        """The planned visits: ``point``, what it ``adds`` to those before it (nats), ``hours``."""
        import pandas as pd

        return pd.DataFrame(self.record["plan"], columns=["point", "adds", "hours"])

    def __repr__(self) -> str:
        return f"<rijke.Suggestions: {', '.join(self.plan['point'])}; {self.record['total'][0]:.3f} nats>"

    def _repr_html_(self) -> str:
        return f"<b>What to measure next: {self.record['total'][0]:.3f} nats</b>" + str(self.plan.to_html(index=False))


def _points(at: Any) -> List[Dict[str, float]]:
    if hasattr(at, "to_dict"):
        # In a table an empty cell says that the part is absent.
        return [{str(name): float(value) for name, value in row.items()} for row in at.to_dict("records")]
    points = [{str(name): float(value) for name, value in row.items()} for row in at or []]
    for k, point in enumerate(points):
        for name, value in point.items():
            if value != value:
                raise InputError(f"point {k}: {name} is not a number", remedy=f"Leave {name} out for that of the nearest point.")
    return points
