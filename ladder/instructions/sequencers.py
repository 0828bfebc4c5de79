"""Sequencer instructions, which step through a table of DINTs with a mask.

LEN is the number of the last step. A program starts at step 0, and step 1 follows the last step.
"""

from __future__ import annotations

from collections.abc import Callable

from ..compiler.sequencers import write_sqi, write_sql, write_sqo
from ..interpreter import Interpreter
from ..interpreter.files import Control, Elements
from ..model.operands import Group, Place, Resolved
from ..model.spec import WITH_CONTROL, Use, condition, on_control
from ..model.types import Elementary
from .prescans import prescan_sets
from .shifts import check_dints

# --- SQI: whether an input matches the step


def _sqi(machine: Interpreter, table: Resolved, mask: Resolved, source: Resolved, group: Group) -> bool:
    """Return whether source and step are equal in the masked bits; set ER if LEN or POS is invalid."""
    control = Control(machine, group)
    position = control["POS"]
    invalid = control["LEN"] <= 0 or not 0 <= position <= control["LEN"]
    control.set(ER=invalid)
    if invalid:
        return False
    entry = machine.whole(Elements(machine, table)[position])
    return (machine.integer(source) ^ entry) & machine.integer(mask) == 0


# --- SQO, SQL: advance one step when the rung becomes true

Step = Callable[[Control], bool]
"""Advances POS on a rising rung; returns whether LEN and POS are valid."""


def _step(control: Control) -> bool:
    """Advance POS on a rising rung, and set DN; if LEN or POS is invalid, set ER and return False."""
    if control["LEN"] <= 0 or control["POS"] < 0:
        control.set(ER=True)
        return False
    if not control["EN"]:
        wraps = control["POS"] >= control["LEN"]
        control.set(EN=True, ER=False, DN=False, POS=1 if wraps else control["POS"] + 1)
    if control["POS"] > control["LEN"]:
        control.set(ER=True)
        return False
    control.set(DN=control["DN"] or control["POS"] == control["LEN"])
    return True


def sequencer_output(
    machine: Interpreter,
    power: bool,
    table: Resolved,
    mask: Resolved,
    target: Place,
    group: Group,
    *_shown: Resolved,
    step: Step = _step,
) -> None:
    """Run SQO: write the masked bits of a step."""
    control = Control(machine, group)
    if not power:
        control.set(EN=False)
    elif step(control):
        bits, value = machine.integer(mask), machine.whole(Elements(machine, table)[control["POS"]])
        kept = machine.whole(machine.get(target)) & ~bits
        machine.put(target, machine.converted(target.type, kept | value & bits))


def sequencer_load(
    machine: Interpreter,
    power: bool,
    table: Resolved,
    source: Resolved,
    group: Group,
    *_shown: Resolved,
    step: Step = _step,
) -> None:
    """Run SQL: store the source in the next step."""
    control = Control(machine, group)
    rises = power and not control["EN"]
    if not power:
        control.set(EN=False)
    elif step(control) and rises:
        elements = Elements(machine, table)
        assert isinstance(elements.type, Elementary)
        elements[control["POS"]] = machine.converted(elements.type, machine.integer(source))


# --- the rows

SQI = condition(
    "SQI",
    *(Use.TABLE, Use.INTEGER, Use.INTEGER, *WITH_CONTROL),
    optional=2,
    check=check_dints,
    run=_sqi,
    write=write_sqi,
    partly=True,
    inline=lambda *_operands: False,
)
SQO = on_control(
    "SQO",
    Use.TABLE,
    Use.INTEGER,
    Use.INTEGER_TARGET,
    check=check_dints,
    run=sequencer_output,
    write=write_sqo,
    partly=True,
    prescan=prescan_sets(-1, EN=True),
    instead="write CASE",
)
SQL = on_control(
    "SQL",
    Use.ARRAY,
    Use.INTEGER,
    check=check_dints,
    run=sequencer_load,
    write=write_sql,
    partly=True,
    prescan=prescan_sets(-1, EN=True),
    instead="write CASE",
)
