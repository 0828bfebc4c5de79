"""Tells whether logic is rungs without importing rungs, since a Python program does not need them."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, TypeGuard

if TYPE_CHECKING:
    from scanrack.ladder import LadderLogic

_HOME = f"{__package__.split('.')[0]}.ladder.lowering.runnable"


def is_rungs(logic: object) -> TypeGuard[LadderLogic]:
    """Return whether logic is a ladder program; it can't be one if its class's module is not loaded."""
    home = sys.modules.get(_HOME)
    return home is not None and isinstance(logic, home.LadderLogic)
