"""What a caller waits for: the import. docs/records/python.md has the times of calls."""

import subprocess
import sys


def test_behaviour_import_loads_nothing_else() -> None:
    script = "import sys, rijke; print(*({'numpy', 'pandas', 'matplotlib', 'arviz'} & set(sys.modules)))"
    shown = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout
    assert shown.split() == []
