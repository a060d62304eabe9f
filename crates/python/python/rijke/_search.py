"""The search over all combinations of candidates, here or on the workers of a Dask client."""

from __future__ import annotations

import os

from . import _native
from ._progress import told
from ._study import Study

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, Dict, List, Optional, Union

    import pandas as pd
    import xarray as xr

    from ._progress import Progress

#: Folders of a study that a search does not read.
_UNREAD = ("live", "records", "results", "search")


def search(
    study: Union[Study, str, "os.PathLike[str]"],
    client: Any = None,
    within: Optional[float] = 20.0,
    *,
    stage: Optional[str] = None,
    trusted: str = "checked",
    parts: Optional[int] = None,
    tasks: Optional[Union[str, "os.PathLike[str]"]] = None,
    progress: Progress = False,
) -> Search:
    """Train every allowed combination of candidates over the stages of a study, as the program ``rijke search`` does.

    Parameters
    ----------
    study : Study or path
        The study. Workers get its files; they need not see its folder.
    client : distributed.Client, optional
        Where to train: a shard of the search is one task of Dask, which gives it to another worker if one is lost. By default here, with
        all processors; Ctrl-C stops.
    within : float or None
        A model that trails the greedy choice by more nats, after its stage and also after the last one if it is continued with the later
        candidates of the greedy choice, is given up with all that stands on it. None gives up nothing.
    stage : str, optional
        The stage at which combinations end: by default the one that stands on most stages.
    trusted : {"checked", "laplace", "nested"}
        How far evidence is checked, as in :meth:`Study.run`.
    parts : int, optional
        How many shards: by default four for each thread of the client's workers.
    tasks : path, optional
        A folder that keeps the result of each task, and from which a later search takes it. On a cluster all workers must see it.
    progress : bool or callable
        True shows a bar in a notebook, else lines. A callable is given how much is done, how much there is, and "": models here,
        at most; shards on a cluster.
    """
    study = study if isinstance(study, Study) else Study(study)
    folder = None if tasks is None else os.path.abspath(os.fspath(tasks))
    if client is None:
        call = told(progress, "model")
        found = [study._native.search(stage, within, trusted, [1, 1], 0, folder, lambda done, of: call(done, of, ""))]
        return Search(_native.merge_searches(found))
    count = parts or 4 * max(1, sum(client.nthreads().values()))
    files = _files(study.folder)
    options = (stage, within, trusted)
    futures = [
        client.submit(_part, files, options, [k, count], folder, key=f"rijke-{_name(files, options)}-{k}-of-{count}")
        for k in range(1, count + 1)
    ]
    if progress:
        from distributed import as_completed

        call = told(progress, "shard")
        for done, _ in enumerate(as_completed(futures)):
            call(done + 1, count, "")
    return Search(_native.merge_searches(client.gather(futures)))


class Search:
    """What a search found.

    Attributes
    ----------
    record : dict
        Everything, as ``rijke search`` writes it to ``search/search.json``.
    """

    def __init__(self, text: str) -> None:
        import json

        self.record: Dict[str, Any] = json.loads(text)

    @property
    def frame(self) -> pd.DataFrame:
        """The combinations that were trained to the end, best first: a column for each role whose candidates differ, ``ln_evidence`` and
        ``behind`` (nats), ``probability``, ``greedy``, ``remark``."""
        import pandas as pd

        roles = [choice["role"] for choice in self.record["choices"]]
        best = self.record["best"]
        rows = [
            {
                **{role: c["candidates"].get(role, "") for role in roles},
                "ln_evidence": c["ln_evidence"],
                "behind": best[0]["ln_evidence"] - c["ln_evidence"],
                "probability": c["probability"],
                "greedy": k + 1 == self.record["greedy"]["rank"],
                "remark": c["remark"],
            }
            for k, c in enumerate(best)
        ]
        return pd.DataFrame(rows)

    @property
    def choices(self) -> pd.DataFrame:
        """The probability of each candidate: ``role``, ``candidate`` (empty for none of the role), ``probability``."""
        import pandas as pd

        rows = [
            {"role": choice["role"], "candidate": id, "probability": p}
            for choice in self.record["choices"]
            for id, p in choice["candidates"]
        ]
        return pd.DataFrame(rows, columns=["role", "candidate", "probability"])

    @property
    def xarray(self) -> xr.Dataset:
        """:attr:`frame` for xarray, over ``combination``."""
        from ._table import dataset

        return dataset(self.frame, "combination")

    def plot_choices(self, ax: Any = None) -> Any:
        """Probability of each candidate, by role; returns matplotlib's axes."""
        from ._plots import choices

        return choices(self, ax)

    @property
    def greedy(self) -> Dict[str, Any]:
        """What ranking stage by stage chose: ``candidates``, ``rank`` among all, ``probability``, ``behind`` (nats)."""
        return dict(self.record["greedy"])

    @property
    def given_up_at_most(self) -> float:
        """The most probability that models hold which were given up, if none of them gains more by other later candidates than the one
        that gained most of those that were followed."""
        return float(self.record["given_up_at_most"])

    def __repr__(self) -> str:
        done, count = len(self.record["best"]), self.record["combinations"]
        return f"<rijke.Search {self.record['study']!r}: {done} of {count} combinations trained to the end>"

    def _repr_html_(self) -> str:
        from ._html import escape, table

        frame = self.frame.drop(columns="remark").head(12)
        return f"<b>{escape(repr(self)[1:-1])}</b>" + table(list(frame.columns), frame.values.tolist())


def _files(folder: str) -> Dict[str, bytes]:
    """What a study consists of, by path."""
    files: Dict[str, bytes] = {}
    for place, folders, names in os.walk(folder):
        if place == folder:
            folders[:] = [name for name in folders if name not in _UNREAD]
        folders[:] = [name for name in folders if not name.startswith(".")]
        for name in names:
            path = os.path.join(place, name)
            with open(path, "rb") as file:
                files[os.path.relpath(path, folder)] = file.read()
    return files


def _name(files: Dict[str, bytes], options: Any) -> str:
    """Tasks of one content have one name, whoever submits them."""
    import hashlib

    hasher = hashlib.sha256(repr((_native.VERSION, options)).encode())
    for path in sorted(files):
        hasher.update(repr((path, files[path])).encode())
    return hasher.hexdigest()[:16]


def _part(files: Dict[str, bytes], options: Any, shard: List[int], tasks: Optional[str]) -> str:
    """One shard, on a worker: it may be done twice, and finds the same."""
    import tempfile

    with tempfile.TemporaryDirectory(prefix="rijke-") as folder:
        for name, content in files.items():
            path = os.path.join(folder, name)
            os.makedirs(os.path.dirname(path), exist_ok=True)
            with open(path, "wb") as file:
                file.write(content)
        stage, within, trusted = options
        return Study(folder)._native.search(stage, within, trusted, shard, 1, tasks, lambda done, of: None)
