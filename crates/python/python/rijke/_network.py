"""Acoustic networks: a file, a text or a dictionary, and what can be asked of it."""

from __future__ import annotations

import os

from . import _native
from ._errors import InputError
from ._table import Table, dataset, with_units

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, Dict, Iterator, List, Mapping, Optional, Sequence, Tuple, Union

    import numpy as np
    import pandas as pd
    import xarray as xr
    from numpy.typing import ArrayLike, NDArray

    Place = Union[int, str]
    Source = Union[str, Tuple[str, Place]]
    Limits = Optional[Sequence[float]]


class Network(_native.Network):
    """An acoustic network: a chain of ducts with devices and two ends.

    Make one with :meth:`from_file`, :meth:`from_str` or :meth:`from_dict`; ``docs/network-file.md`` says what a file
    may hold. A network does not change; :meth:`replace` makes another. It can be pickled and used by several threads.

    Examples
    --------
    >>> tube = Network.from_dict({
    ...     "upstream": {"type": "closed"}, "downstream": {"type": "open"},
    ...     "element": [{"name": "tube", "type": "duct", "length": 0.5, "diameter": 0.05}],
    ... })
    >>> s = tube.solve(1000j)
    >>> f"{s.imag / 6.283185307:.1f} Hz"
    '171.6 Hz'
    >>> ds = tube.gradient(s, ["tube.length"])  # a longer tube is lower, by s/L per metre
    >>> abs(ds["tube.length"] + s / 0.5) < 1e-7
    True
    """

    @classmethod
    def from_file(cls, path: Union[str, "os.PathLike[str]"]) -> Network:
        """Read a network file (TOML).

        Raises
        ------
        InputError
            With file, line, element and remedy.
        """
        name = os.fspath(path)
        try:
            with open(name, encoding="utf-8") as file:
                text = file.read()
        except (OSError, UnicodeDecodeError) as error:
            raise InputError(f"cannot be read: {error}", name, None, "Name a network file.") from error
        return cls(text, name)

    @classmethod
    def from_str(cls, text: str) -> Network:
        """Read the text of a network file."""
        return cls(text)

    @classmethod
    def from_dict(cls, tables: Mapping[str, Any]) -> Network:
        """Take the tables of a network file as dictionaries, its ``[[element]]`` as a list of dictionaries.

        ``None`` stands for a key that is left out; NumPy's numbers and arrays are welcome.
        """
        return cls(cls.text_of(tables))

    def replace(self, numbers: Mapping[str, float]) -> Network:
        """The same network with other values of some :meth:`numbers`, by name."""
        return type(self)(self.text_with([(name, float(value)) for name, value in numbers.items()]), self.source)

    def modes(self, growth_rate: Limits = None, frequency_hz: Limits = None) -> Modes:
        """Every mode in a region of the s-plane, counted by a contour integral.

        Parameters
        ----------
        growth_rate, frequency_hz : (low, high), optional
            The region, 1/s and Hz; that of the file's ``[search]`` if not given.
        """
        return Modes(network=self, **self.find_modes(growth_rate, frequency_hz))

    def gradient(self, s: complex, names: Optional[Sequence[str]] = None) -> Dict[str, complex]:
        """ds/d(number) of the eigenvalue ``s``: 1/s and rad/s per unit of the number.

        Parameters
        ----------
        s : complex
            An eigenvalue of this network.
        names : list of str, optional
            Names of :meth:`numbers`; every one on which s can depend smoothly if not given.
        """
        self._is_mode(s)
        if names is not None:
            return dict(zip(names, map(complex, self.derivatives(s, list(names)))))
        found = {}
        for name in self.numbers():
            if name.split(".")[0] == "search":
                continue
            try:
                found[name] = complex(self.derivatives(s, [name])[0])
            except InputError:  # a count, or a number that cannot change by a part in a thousand
                continue
        return found

    def budget(self, s: complex) -> Dict[str, float]:
        """Where the growth rate of the mode ``s`` comes from: shares by end, wall and element, 1/s; they add up to it."""
        self._is_mode(s)
        return self.account(s)[1]

    def condition(self, s: complex) -> float:
        """How much relative errors of the network's numbers are magnified in ``s``."""
        self._is_mode(s)
        return self.account(s)[0]

    def along(self, s: complex, samples: Optional[int] = None) -> Along:
        """The mode ``s``, and what a small change anywhere would do to it, along x.

        Parameters
        ----------
        samples : int, optional
            Points in each duct, ends included; enough for smooth curves if not given.
        """
        self._is_mode(s)
        return Along(s=s, **self.stations(s, samples))

    def _is_mode(self, s: complex) -> None:
        """Refuses an ``s`` that is no eigenvalue, to the digits that are usually printed."""
        nearest = complex(self.solve(s))
        if not abs(nearest - s) <= 1e-3 * abs(nearest):
            raise InputError(f"s = {s:.6g} is no eigenvalue of this network", remedy=f"Use solve(s): from there it finds {nearest:.6g}.")

    def poles(self, growth_rate: Limits = None, frequency_hz: Limits = None) -> NDArray[np.complex128]:
        """Poles of laws within the region, 1/s and rad/s. They are not modes."""
        return self.find_poles(growth_rate, frequency_hz)

    def response(self, frequency_hz: ArrayLike, source: Source = "upstream") -> Response:
        """Pressure and velocity everywhere per unit of a source. The gas must be at rest.

        Parameters
        ----------
        frequency_hz : array, shape (n,)
            Frequencies of forcing, Hz. Complex ones are allowed: s = 2 pi i f.
        source : str or (str, place)
            ``"upstream"`` or ``"downstream"``: a wave of 1 Pa that enters there. ``("velocity", place)``: 1 m/s of
            volume flow per area, a loudspeaker in the wall. ``("pressure", place)``: 1 Pa. A place is its number or the
            name of an element that acts there.
        """
        import numpy as np

        frequency = np.atleast_1d(np.asarray(frequency_hz))
        kind, place = (source, None) if isinstance(source, str) else source
        found = self.forced(2j * np.pi * frequency, kind, place)
        before, behind = found[:, :, 0], found[:, :, 1]
        return Response(
            frequency_hz=frequency,
            x=self.positions,
            pressure=behind[..., 0],
            velocity=behind[..., 1],
            pressure_before=before[..., 0],
            velocity_before=before[..., 1],
        )

    def impedance(self, frequency_hz: ArrayLike, place: Place) -> NDArray[np.complex128]:
        """p/u (Pa s/m) of what lies downstream of a place, seen from just before it; shape (n,)."""
        return self.seen_from(_angular(frequency_hz), place, False)

    def reflection(self, frequency_hz: ArrayLike, place: Place) -> NDArray[np.complex128]:
        """g/f of what lies downstream of a place, seen from just before it; shape (n,)."""
        return self.seen_from(_angular(frequency_hz), place, True)

    def transfer(self, frequency_hz: ArrayLike, first: Place, last: Place) -> NDArray[np.complex128]:
        """The matrix from (p, u) before one place to (p, u) behind another; shape (n, 2, 2)."""
        return self.between(_angular(frequency_hz), (first, last), False)

    def scattering(self, frequency_hz: ArrayLike, first: Place, last: Place) -> NDArray[np.complex128]:
        """Waves that leave, (reflected, transmitted), per waves that arrive (upstream, downstream); shape (n, 2, 2)."""
        return self.between(_angular(frequency_hz), (first, last), True)

    def plot_modes(self, ax: Any = None) -> Any:
        """The modes in the s-plane; returns matplotlib's axes."""
        return self.modes().plot(ax)

    def __repr__(self) -> str:
        flow = "" if self.at_rest else ", with mean flow"
        return f"<rijke.Network {self.name or self.source or ''!r}: {self.length:g} m, {len(self.numbers())} numbers{flow}>"

    def _repr_html_(self) -> str:
        from ._html import escape, table

        rows = [[place, name, f"{x:g}"] for place, name, x in self.places]
        kind = "gas at rest" if self.at_rest else "with mean flow"
        head = f"<b>{escape(self.name or 'Network')}</b>: {self.length:g} m, {kind}"
        warnings = "".join(f"<br>warning: {escape(warning)}" for warning in self.warnings)
        return head + warnings + table(["place", "element", "x / m"], rows)


class Modes(Table):
    """The modes of a region, in order of frequency. ``counted`` of them were counted by the contour integral.

    Attributes
    ----------
    s : array of complex, shape (n,)
        Growth rate + i angular frequency, 1/s and rad/s.
    frequency_hz : array, shape (n,)
    residual : array, shape (n,)
        The relative error that Newton still sees.
    multiplicity : array of int, shape (n,)
    condition : array, shape (n,)
        How much relative errors of the network's numbers are magnified in s.
    shares : list of dict
        By mode: where its growth rate comes from, 1/s.
    counted, poles : int
        Modes by the contour integral, and poles of laws told apart from them.
    """

    network: Network
    s: NDArray[np.complex128]
    frequency_hz: NDArray[np.float64]
    residual: NDArray[np.float64]
    multiplicity: NDArray[np.int64]
    condition: NDArray[np.float64]
    shares: List[Dict[str, float]]
    counted: int
    poles: int

    @property
    def growth_rate(self) -> NDArray[np.float64]:
        """1/s; negative decays. Shape (n,)."""
        return self.s.real

    @property
    def frame(self) -> pd.DataFrame:
        """A table: a row per mode, with its shares of the growth rate (1/s) by name."""
        import pandas as pd

        own = {"frequency_hz": self.frequency_hz, "growth_rate": self.growth_rate}
        last = {"condition": self.condition, "residual": self.residual, "multiplicity": self.multiplicity}
        return pd.concat([pd.DataFrame(own), pd.DataFrame(self.shares), pd.DataFrame(last)], axis=1)

    @property
    def xarray(self) -> xr.Dataset:
        """The table for xarray, over ``mode``; with ``s``."""
        return dataset(self.frame.assign(s=self.s), "mode")

    def __len__(self) -> int:
        return len(self.s)

    def __iter__(self) -> Iterator[complex]:
        return map(complex, self.s)

    def __getitem__(self, k: int) -> complex:
        return complex(self.s[k])

    def plot(self, ax: Any = None) -> Any:
        """The modes in the s-plane; returns matplotlib's axes."""
        from ._plots import modes

        return modes(self, ax)

    def __repr__(self) -> str:
        words = ", ".join(f"{f:.2f} Hz {g:+.3f} 1/s" for f, g in zip(self.frequency_hz, self.growth_rate))
        return f"<{len(self)} of {self.counted} modes: {words}>"

    def _repr_html_(self) -> str:
        from ._html import table

        names = list(self.shares[0]) if self.shares else []
        head = ["frequency / Hz", "growth rate / s<sup>-1</sup>", *names, "condition"]
        rows = [
            [f"{f:.4f}", f"{g:.4f}", *(f"{share[name]:.4f}" for name in names), f"{c:.1f}"]
            for f, g, share, c in zip(self.frequency_hz, self.growth_rate, self.shares, self.condition)
        ]
        return table(head, rows) + f"{len(self)} of {self.counted} modes found"


class Along(Table):
    """A mode and what small changes would do to it, along x. All arrays have the shape (n,).

    Attributes
    ----------
    x : m from the upstream end
    pressure, velocity : complex
        Of the mode, the largest pressure being 1; the velocity times rho c.
    by_screen : complex
        ds per e of a screen that takes e rho c u, 1/s.
    by_heat : complex
        ds per e of a heater that adds e u in phase, 1/s.
    by_leak : complex
        ds per e of a leak that takes e p/(rho c), 1/s.
    by_area, by_temperature : complex
        ds per metre over which area or temperature are larger by 100 %, 1/(s m).
    """

    s: complex
    x: NDArray[np.float64]
    pressure: NDArray[np.complex128]
    velocity: NDArray[np.complex128]
    by_screen: NDArray[np.complex128]
    by_heat: NDArray[np.complex128]
    by_leak: NDArray[np.complex128]
    by_area: NDArray[np.complex128]
    by_temperature: NDArray[np.complex128]

    @property
    def frame(self) -> pd.DataFrame:
        """A table: a row per station."""
        import pandas as pd

        return pd.DataFrame({name: value for name, value in vars(self).items() if name != "s"})

    @property
    def xarray(self) -> xr.Dataset:
        """The table for xarray, over ``x`` (m). Where the area jumps, one x stands twice."""
        return dataset(self.frame, "x")

    def plot(self, axes: Any = None) -> Any:
        """Mode shape and sensitivities of the growth rate; returns matplotlib's two axes."""
        from ._plots import along

        return along(self, axes)


class Response(Table):
    """Pressure and velocity per unit of a source, by frequency and place: arrays of complex, shape (n, places).

    Attributes
    ----------
    frequency_hz : array, shape (n,)
    x : array, shape (places,)
        Where the places are, m.
    pressure, velocity : Pa and m/s
        Just behind each place.
    pressure_before, velocity_before : Pa and m/s
        Just before it.
    """

    _FIELDS = ("pressure", "velocity", "pressure_before", "velocity_before")

    frequency_hz: NDArray[Any]
    x: NDArray[np.float64]
    pressure: NDArray[np.complex128]
    velocity: NDArray[np.complex128]
    pressure_before: NDArray[np.complex128]
    velocity_before: NDArray[np.complex128]

    @property
    def frame(self) -> pd.DataFrame:
        """A table: a row per frequency and place."""
        import numpy as np
        import pandas as pd

        n, places = self.pressure.shape
        columns = {name: getattr(self, name).ravel() for name in self._FIELDS}
        place, x = np.tile(np.arange(places), n), np.tile(self.x, n)
        return pd.DataFrame({"frequency_hz": np.repeat(self.frequency_hz, places), "place": place, "x": x, **columns})

    @property
    def xarray(self) -> xr.Dataset:
        """For xarray, over ``frequency_hz`` and ``place``; ``x`` (m) is a coordinate of the place."""
        import numpy as np
        import xarray as xr

        fields = {name: (("frequency_hz", "place"), getattr(self, name)) for name in self._FIELDS}
        places = {"place": np.arange(len(self.x)), "x": ("place", self.x)}
        units = {name: "Pa" if name.startswith("pressure") else "m/s" for name in self._FIELDS}
        return with_units(xr.Dataset(fields, {"frequency_hz": self.frequency_hz, **places}), {**units, "x": "m", "frequency_hz": "Hz"})

    def plot(self, place: int = 0, ax: Any = None) -> Any:
        """Modulus of the pressure behind a place against frequency; returns matplotlib's axes."""
        from ._plots import response

        return response(self, place, ax)


def _angular(frequency_hz: ArrayLike) -> NDArray[np.complex128]:
    import numpy as np

    angular: NDArray[np.complex128] = 2j * np.pi * np.atleast_1d(np.asarray(frequency_hz))
    return angular
