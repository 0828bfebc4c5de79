"""Instruction sets by the name of their dialect."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from ..instructions import BY_NAME
from ..instructions.slc import SLC_SPECS
from ..instructions.slc.processor import after_scan, before_scan
from ..model.spec import Spec

LOGIX, SLC = "logix", "slc"

DIALECTS: Mapping[str, Mapping[str, Spec]] = {LOGIX: BY_NAME, SLC: SLC_SPECS}
"""Instruction sets of Logix 5000 controllers, and of SLC 500 and MicroLogix."""

Hooks = tuple[tuple[Callable[[Any, bool], None], ...], tuple[Callable[[Any], None], ...]]

HOOKS: Mapping[str, Hooks] = {LOGIX: ((), ()), SLC: ((before_scan,), (after_scan,))}
"""Functions of the processor before and after each scan; see `LoweredProgram.opening` and `closing`."""
