"""Scans as Foxglove's JavaScript decodes them; a test is skipped where Node.js or a package is missing."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

SCRIPT = Path(__file__).parents[1] / "peers" / "read_tags.cjs"
PACKAGES = ("@mcap/core", "fzstd", "@foxglove/rosmsg", "@foxglove/rosmsg2-serialization")


def decoded_scans(path: Path, *, whole: bool = False) -> Any:
    """Return the tags of every scan of a trace, or whole scans; 64-bit integers as text."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed")
    for package in PACKAGES:
        script = f"require.resolve({package!r}, {{paths: [{str(SCRIPT.parent)!r}]}})"
        if subprocess.run([node, "-e", script], capture_output=True, check=False).returncode:
            pytest.skip(f"the npm package {package} is not installed where node finds it (NODE_PATH)")
    command = [node, str(SCRIPT), str(path), *(["whole"] if whole else [])]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False, encoding="utf-8")
    assert (done.returncode, done.stderr) == (0, "")
    return json.loads(done.stdout)
