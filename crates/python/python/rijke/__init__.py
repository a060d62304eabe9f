"""Thermoacoustics: acoustic networks with exact derivatives, and models chosen by evidence.

SI units throughout. s = growth rate (1/s) + i angular frequency (rad/s), time dependence e^{st}, as Python's ``complex``.

>>> import rijke
>>> tube = rijke.Network.from_dict({
...     "upstream": {"type": "open"}, "downstream": {"type": "open"},
...     "element": [{"type": "duct", "length": 1.0, "diameter": 0.05}],
... })
>>> round(tube.modes().frequency_hz[0], 1)
171.6

pandas, matplotlib, ArviZ and NumPy are imported where they are first needed, so that ``import rijke`` is quick.
"""

from ._errors import ComputationError, InputError, RijkeError
from ._native import VERSION as __version__
from ._network import Along, Modes, Network, Response
from ._own import Data, Noise, OwnModel, Parameter, Ranking, half_normal, log_normal, normal, rank, uniform
from ._posterior import Model, Posterior
from ._search import Search, search
from ._study import Results, Stage, Study, Suggestions

__all__ = [
    "Along",
    "ComputationError",
    "Data",
    "InputError",
    "Model",
    "Modes",
    "Network",
    "Noise",
    "OwnModel",
    "Parameter",
    "Posterior",
    "Ranking",
    "Response",
    "Results",
    "RijkeError",
    "Search",
    "Stage",
    "Study",
    "Suggestions",
    "__version__",
    "half_normal",
    "log_normal",
    "normal",
    "rank",
    "search",
    "uniform",
]
