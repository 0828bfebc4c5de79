"""The process that answers a long question. It prints a line of JSON: the answer or `{"refused": TEXT}`."""

from __future__ import annotations

import json
import os
import pickle
import sys
from importlib import import_module

NICENESS = 10
"""Increment of niceness, so that scans and frames have a higher priority, see nice(2)."""


def main(module: str) -> None:
    """Call `answer` of a module with pickled arguments from standard input; its ValueError is a refusal."""
    if hasattr(os, "nice"):
        os.nice(NICENESS)
    try:
        result = import_module(module).answer(*pickle.load(sys.stdin.buffer))
    except ValueError as error:
        result = {"refused": str(error)}
    sys.stdout.write(json.dumps(result))
