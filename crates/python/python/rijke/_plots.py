"""Figures. matplotlib is imported here and nowhere else."""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from ._network import Along, Modes, Response
    from ._own import Ranking
    from ._search import Search
    from ._study import Stage


def _axes(ax: Any, rows: int = 1) -> Any:
    if ax is not None:
        return ax
    import matplotlib.pyplot as plt

    return plt.subplots(rows, 1, sharex=True, constrained_layout=True)[1]


def modes(found: Modes, ax: Any) -> Any:
    ax = _axes(ax)
    ax.plot(found.growth_rate, found.frequency_hz, "o")
    ax.axvline(0.0, color="0.6", linewidth=0.8)
    ax.set_xlabel("growth rate / s$^{-1}$")
    ax.set_ylabel("frequency / Hz")
    ax.set_title(found.network.name or "")
    return ax


def along(found: Along, axes: Any) -> Any:
    shape, effect = axes = _axes(axes, 2)
    shape.plot(found.x, abs(found.pressure), label="|p|")
    shape.plot(found.x, abs(found.velocity), label=r"|$\rho c\,u$|")
    for name, word in [("by_screen", "screen"), ("by_heat", "heater"), ("by_leak", "leak")]:
        effect.plot(found.x, getattr(found, name).real, label=word)
    effect.axhline(0.0, color="0.6", linewidth=0.8)
    effect.set_xlabel("x / m")
    effect.set_ylabel(r"d$\sigma$/d$e$ / s$^{-1}$")
    shape.legend()
    effect.legend()
    return axes


def response(found: Response, place: int, ax: Any) -> Any:
    ax = _axes(ax)
    ax.semilogy(found.frequency_hz, abs(found.pressure[:, place]))
    ax.set_xlabel("frequency / Hz")
    ax.set_ylabel(f"|p| at x = {found.x[place]:g} m / Pa")
    return ax


def stage(found: Stage, ax: Any) -> Any:
    """Evidence of the models of a stage, best above."""
    ax = _evidence(found.models, "id", ax)
    ax.set_title(found.title)
    return ax


def ranking(found: Ranking, ax: Any) -> Any:
    return _evidence(found.frame, "name", ax)


def _evidence(models: Any, name: str, ax: Any) -> Any:
    ax = _axes(ax)
    models = models.dropna(subset=["ln_marginal"]).sort_values("ln_marginal")
    ax.barh(models[name], models["ln_marginal"] - models["ln_marginal"].max())
    ax.set_xlabel("ln evidence below the best / nats")
    return ax


def choices(found: Search, ax: Any) -> Any:
    """Probability of each candidate, a bar each."""
    ax = _axes(ax)
    frame = found.choices[::-1]
    words = [f"{role}: {candidate or 'none'}" for role, candidate in zip(frame["role"], frame["candidate"])]
    ax.barh(words, frame["probability"])
    ax.set_xlabel("probability")
    return ax


def predictions(found: Stage, quantity: str, ax: Any) -> Any:
    """Predicted against measured, with a standard deviation of a new measurement."""
    ax = _axes(ax)
    frame = found.predictions.dropna(subset=[f"measured_{quantity}"])
    measured = frame[f"measured_{quantity}"]
    ax.errorbar(measured, frame[quantity], frame[f"{quantity}_sd"], fmt="o")
    ends = [measured.min(), measured.max()]
    ax.plot(ends, ends, color="0.6", linewidth=0.8)
    unit = {"growth_rate": "s$^{-1}$", "angular_frequency": "rad/s"}[quantity]
    ax.set_xlabel(f"measured {quantity.replace('_', ' ')} / {unit}")
    ax.set_ylabel(f"predicted / {unit}")
    return ax
