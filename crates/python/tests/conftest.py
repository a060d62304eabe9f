"""Where the files of the repository are, and the program to compare with."""

import os
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
NETWORKS = ROOT / "fixtures" / "networks"


def _program() -> Path:
    """The program `rijke`: of RIJKE, or built by cargo."""
    given = os.environ.get("RIJKE")
    if given:
        return Path(given)
    build = ["cargo", "build", "--release", "--locked", "--workspace", "--bin", "rijke"]
    subprocess.run(build, cwd=ROOT, check=True)
    return ROOT / "target" / "release" / "rijke"


@pytest.fixture(scope="session")
def program() -> Path:
    return _program()


@pytest.fixture(scope="session")
def tube() -> str:
    return str(NETWORKS / "rijke-tube.toml")
