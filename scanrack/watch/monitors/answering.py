"""The process for a long question: it prints one line of JSON, the answer or `{"refused"}`."""

from __future__ import annotations

import json
import os
import pickle
import sys
from importlib import import_module

MODESTY = 10
"""Increment of niceness, for a lower priority than scans and frames, see nice(2)."""


def main(module: str) -> None:
    """Call `answer` of a module with pickled arguments from standard input; a ValueError refuses."""
    if hasattr(os, "nice"):
        os.nice(MODESTY)
    try:
        result = import_module(module).answer(*pickle.load(sys.stdin.buffer))
    except ValueError as error:
        result = {"refused": str(error)}
    sys.stdout.write(json.dumps(result))
