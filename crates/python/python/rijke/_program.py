"""The steps that the program ``rijke`` does beside this package: records into observations, clicks into the flow."""

from __future__ import annotations

import os

from ._errors import ComputationError, InputError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, List


def call(words: List[str]) -> Any:
    """Run ``rijke``; returns what it prints as JSON, and raises what it says is wrong. Ctrl-C ends it.

    The program is that which RIJKE names, or lies beside this Python, or on the PATH.
    """
    import json
    import shutil
    import subprocess
    import sys

    beside = shutil.which("rijke", path=os.path.dirname(sys.executable))
    program = os.environ.get("RIJKE") or beside or shutil.which("rijke")
    if program is None:
        remedy = "Install it with `cargo install --path crates/rijke`, or name it in the variable RIJKE."
        raise InputError("the program `rijke`, which does this step, is not installed", None, None, remedy)
    # It ends itself as soon as its input is closed, so that it does not outlive this process.
    with subprocess.Popen(
        [program, "--until-stdin-closes", *words, "--json"],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, encoding="utf-8",
    ) as child:
        try:
            assert child.stdout is not None and child.stderr is not None
            import threading

            said: List[str] = []
            listener = threading.Thread(target=lambda: said.extend(child.stderr or ()))
            listener.start()
            answer = child.stdout.read()
            status = child.wait()
            listener.join()
        except BaseException:
            child.kill()
            raise
    if status == 0:
        return json.loads(answer)
    try:
        found = json.loads(said[-1])
    except (IndexError, ValueError):
        raise ComputationError(f"`rijke {words[0]}` ended with status {status}: {''.join(said)}") from None
    message = "\n  because: ".join([found["error"], *found["because"]])
    kind = InputError if found["exit_status"] == 2 else ComputationError
    raise kind(message, None, None, found["remedy"])
