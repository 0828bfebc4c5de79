"""Whether logic is rungs, without an import of rungs: a program in Python needs none."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, TypeGuard

if TYPE_CHECKING:
    from scanrack.ladder import LadderLogic

_HOME = f"{__package__.split('.')[0]}.ladder.lowering.runnable"


def is_rungs(logic: object) -> TypeGuard[LadderLogic]:
    """Whether logic is a ladder program; without the module of its class there is none."""
    home = sys.modules.get(_HOME)
    return home is not None and isinstance(logic, home.LadderLogic)
