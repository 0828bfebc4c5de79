"""SQI, SQO and SQL as Python code, see `instructions.sequencers`."""

from __future__ import annotations

from ..model.operands import Group, Place, Resolved
from ..model.types import DINT
from .files import ControlText, ElementText, converted_text, has_elements
from .rungs import RungWriter


def _integer(rungs: RungWriter, operand: Resolved) -> str:
    """Return a variable that contains an integer operand."""
    return rungs.values.keep(rungs.values.term(operand, DINT.bits).text)


def _element(rungs: RungWriter, table: Resolved, number: str) -> str:
    """Write the check of an element number; return text for the element."""
    elements = ElementText(rungs, table)
    elements.check(number)
    return elements[number]


def write_sqi(rungs: RungWriter, table: Resolved, mask: Resolved, source: Resolved, group: Group) -> str:
    """Write SQI; return text that is true if the input matches the step."""
    if not has_elements(rungs, table):
        return rungs.interpreted()
    control, keep = ControlText(rungs, group), rungs.values.keep
    position, length = keep(control["POS"]), keep(control["LEN"])
    invalid = keep(f"{length} <= 0 or not 0 <= {position} <= {length}")
    control.set(ER=invalid)
    matched = keep("False")
    with rungs.writer.block(f"if not {invalid}:"):
        entry = keep(_element(rungs, table, position))
        value, bits = _integer(rungs, source), _integer(rungs, mask)
        rungs.writer.line(f"{matched} = ({value} ^ {entry}) & {bits} == 0")
    return matched


def _write_step(rungs: RungWriter, control: ControlText) -> str:
    """Write code that moves to the next step; return a variable that is true if LEN and POS are valid."""
    block = rungs.writer.block
    valid = rungs.values.keep("False")
    with block(f"if {control['LEN']} <= 0 or {control['POS']} < 0:"):
        control.set(ER=True)
    with block("else:"):
        with block(f"if not {control['EN']}:"):
            control.set(EN=True, ER=False, DN=False)
            control.set(POS=f"1 if {control['POS']} >= {control['LEN']} else {control['POS']} + 1")
        with block(f"if {control['POS']} > {control['LEN']}:"):
            control.set(ER=True)
        with block("else:"):
            control.set(DN=f"{control['DN']} or {control['POS']} == {control['LEN']}")
            rungs.writer.line(f"{valid} = True")
    return valid


def write_sqo(
    rungs: RungWriter, power: str, table: Resolved, mask: Resolved, target: Place, group: Group
) -> None:
    """Write SQO, which moves to the next step when the rung becomes true; a true rung outputs the step."""
    if not has_elements(rungs, table):
        rungs.interpret(power)
        return
    control, values = ControlText(rungs, group), rungs.values

    def when_true() -> None:
        with rungs.writer.block(f"if {_write_step(rungs, control)}:"):
            bits = _integer(rungs, mask)
            entry = values.keep(_element(rungs, table, values.keep(control["POS"])))
            value = f"{values.read(target)} & ~{bits} | {entry} & {bits}"
            values.assign(target, f"converted(types[{target.type.name!r}], {value})")

    rungs.either(power, when_true, lambda: control.set(EN=False))


def write_sql(rungs: RungWriter, power: str, table: Resolved, source: Resolved, group: Group) -> None:
    """Write SQL, which moves to the next step and stores the source in it when the rung becomes true."""
    if not has_elements(rungs, table):
        rungs.interpret(power)
        return
    control, values = ControlText(rungs, group), rungs.values

    def when_true() -> None:
        rises = values.keep(f"not {control['EN']}")
        with rungs.writer.block(f"if {_write_step(rungs, control)} and {rises}:"):
            value = values.keep(converted_text(values.term(source, DINT.bits), DINT))
            element = _element(rungs, table, values.keep(control["POS"]))
            rungs.writer.line(f"{element} = {value}")

    rungs.either(power, when_true, lambda: control.set(EN=False))
