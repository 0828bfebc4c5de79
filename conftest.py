"""Tests of a checkout run its own files, installed or not, and so do the processes that they start."""

import os
from pathlib import Path

pytest_plugins = ("scanrack.pytest_plugin",)  # pyproject.toml leaves out the one that is installed

os.environ["PYTHONPATH"] = os.pathsep.join(
    filter(None, [str(Path(__file__).parent), os.environ.get("PYTHONPATH")])
)
