"""The debugger of a test run, which pytest's configuration keeps."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from scanrack.jobs.bench import Bench

DEBUG = pytest.StashKey[Callable[["Bench"], object]]()
"""What is called with each bench when it is opened."""
