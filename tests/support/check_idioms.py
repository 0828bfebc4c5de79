"""Correct programs for `scanrack check` in all languages, one idiom of PLC programmers each."""

from __future__ import annotations

from check_idioms_more import MORE
from check_idioms_python import BY_HAND, WITH_AWAIT
from check_idioms_rungs import RUNGS
from check_idioms_text import STEPS, TEXT

IDIOMS = {**RUNGS, **TEXT, **STEPS, **BY_HAND, **WITH_AWAIT, **MORE}
"""The programs by name: rungs, structured text, lists of steps, Python by hand and with `await`."""
