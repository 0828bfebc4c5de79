"""Instructions that act when their rung becomes true: compiled code detects it, the interpreter runs them.

While the rung does not change, the instruction is therefore as fast as any other, see `Spec.partly`.
"""

from __future__ import annotations

from ..model.operands import Group, Resolved
from ..model.types import MESSAGE_BITS
from .files import ControlText, MemberText
from .rungs import RungWriter


def write_once(rungs: RungWriter, power: str, *operands: Resolved) -> None:
    """Write AVE, STD or SRT; the last operand is the control."""
    control = _control(rungs, operands[-1])

    def when_true() -> None:
        with rungs.writer.block(f"if not ({control['EN']} or {control['ER']}):"):
            rungs.interpret("True")

    def when_false() -> None:
        control.begin_again()
        control.set(EN=False, ER=False)

    rungs.either(power, when_true, when_false)


def write_comparison(rungs: RungWriter, power: str, *operands: Resolved) -> None:
    """Write FBC or DDT; the last two operands are the controls of the search and of its results."""
    search, results = (_control(rungs, operand) for operand in operands[-2:])

    def when_true() -> None:
        with rungs.writer.block(f"if not {search['EN']}:"):
            rungs.interpret("True")

    def when_false() -> None:
        search.set(EN=False, ER=False, FD=False)
        for control in (search, results):
            control.begin_again()

    rungs.either(power, when_true, when_false)


def write_message(rungs: RungWriter, power: str, group: Group) -> None:
    """Write MSG, which does nothing while it is idle or done and the rung does not change."""
    flags = rungs.values.keep(MemberText(rungs, group)["FLAGS"])
    power = rungs.kept(power)
    enabled, over = 1 << MESSAGE_BITS["EN"], 1 << MESSAGE_BITS["DN"] | 1 << MESSAGE_BITS["ER"]
    with rungs.writer.block(f"if not {power} or not {flags} & {over} if {flags} & {enabled} else {power}:"):
        rungs.interpret(power)


def _control(rungs: RungWriter, operand: Resolved) -> ControlText:
    assert isinstance(operand, Group)
    return ControlText(rungs, operand)
