"""What found things have in common."""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, Dict

    import pandas as pd
    import xarray as xr

#: Units of the columns that results have in common.
_UNITS = {
    "growth_rate": "1/s", "angular_frequency": "rad/s", "frequency_hz": "Hz", "x": "m",
    "by_screen": "1/s", "by_heat": "1/s", "by_leak": "1/s", "by_area": "1/(s m)", "by_temperature": "1/(s m)",
    "ln_best_fit": "nats", "ln_occam": "nats", "ln_marginal": "nats", "below": "nats", "ln_evidence": "nats", "behind": "nats",
}


class Table:
    """Named arrays that belong together. They are attributes, and are not to be changed."""

    def __init__(self, **columns: Any) -> None:
        self.__dict__.update(columns)


def dataset(frame: pd.DataFrame, over: str) -> xr.Dataset:
    """A table for xarray: a variable per column, over the column ``over`` or else over the row, with units where columns have some."""
    index = frame.set_index(over) if over in frame else frame.rename_axis(over)
    return with_units(index.to_xarray())


def with_units(data: xr.Dataset, units: Dict[str, str] = _UNITS) -> xr.Dataset:
    """Says the unit of each variable that is known by name, in its ``attrs``."""
    for name, variable in data.variables.items():
        plain = str(name)
        for word in ("measured_", "averaged_"):
            plain = plain[len(word):] if plain.startswith(word) else plain
        for word in ("_model_sd", "_sd", "_before"):
            plain = plain[: -len(word)] if plain.endswith(word) else plain
        if plain in units:
            variable.attrs["units"] = units[plain]
    return data
