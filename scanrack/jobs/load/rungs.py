"""Tells whether logic is a ladder program, without importing ladder code for a Python program."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, TypeGuard

if TYPE_CHECKING:
    from scanrack.ladder import LadderLogic

_MODULE_NAME = f"{__package__.split('.')[0]}.ladder.lowering.runnable"


def is_rungs(logic: object) -> TypeGuard[LadderLogic]:
    """Return whether logic is a ladder program; none can exist before the ladder module is imported."""
    module = sys.modules.get(_MODULE_NAME)
    return module is not None and isinstance(logic, module.LadderLogic)
