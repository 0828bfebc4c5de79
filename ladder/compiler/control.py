"""Program control: jumps, routines, add-on instructions, MCR."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..lowered import AddOnCall, Call
from ..operands import Place, Resolved

if TYPE_CHECKING:
    from .steps import RungWriter


def jmp(rungs: RungWriter, label: str) -> None:
    """JMP: go on at a label."""
    if rungs.sections[label] <= rungs.section:
        rungs.writer.line(f"jumped_back({rungs.values.site})")
    rungs.writer.line(f"at = {rungs.sections[label]}")
    rungs.writer.line("continue")


def jsr(rungs: RungWriter, call: Call) -> None:
    """JSR: call a routine, of rungs or in Python, and take its answers."""
    inputs = "".join(f"{_plain(rungs, each)}, " for each in call.inputs)
    if call.routine in rungs.writer.lowered.functions:
        text = f"python({call.routine!r}, ({inputs}))"
    else:
        text = f"{rungs.functions[call.routine]}(now, ({inputs}))"
    if not call.returns:
        rungs.writer.line(text)
        return
    answers = rungs.values.keep(f"{text} or ()")
    for number, place in enumerate(call.returns):
        with rungs.writer.block(f"if len({answers}) > {number}:"):
            _take(rungs, place, f"{answers}[{number}]")


def add_on(rungs: RungWriter, power: str, call: AddOnCall) -> str:
    """Call an add-on instruction; return the power behind it."""
    power = rungs.kept(power)
    for series in call.inputs:
        rungs.series(series, "True", needed=False)
    rungs.values.set_bit(call.enable_in, power)
    rungs.values.set_bit(call.enable_out, power)

    def run(routine: str | None) -> None:
        if routine is None:
            return
        rungs.writer.line(f"{rungs.functions[routine]}(now, ())")
        for series in call.outputs:
            rungs.series(series, "True", needed=False)

    rungs.either(power, lambda: run(call.logic), lambda: run(call.otherwise))
    return rungs.values.keep(rungs.values.read(call.enable_out))


def _plain(rungs: RungWriter, operand: Resolved) -> str:
    return rungs.values.leaf_term(operand).text


def _take(rungs: RungWriter, place: Place, text: str) -> None:
    """Write a parameter into its tag."""
    rungs.values.before()
    kind = place.type
    value = rungs.values.keep(f"answer({rungs.values.site}, {text}, {kind.name!r})")
    if kind.is_bool:
        rungs.values.set_bit(place, value)
        return
    rungs.values.assign(place, value)
    if rungs.writer.flags:
        rungs.values.result_flags(place)


def parameters(rungs: RungWriter, power: str, places: tuple[Place, ...]) -> None:
    """SBR: take what JSR hands over."""
    with rungs.writer.block(f"if {power}:"):
        for number, place in enumerate(places):
            _take(rungs, place, f"given[{number}]")


def ret(rungs: RungWriter, *values: Resolved) -> None:
    """RET: hand values back and leave the routine."""
    rungs.writer.line(f"return ({''.join(f'{_plain(rungs, each)}, ' for each in values)})")


def tnd(rungs: RungWriter) -> None:
    """TND: leave the routine."""
    rungs.writer.line("return ()")


def mcr(rungs: RungWriter, power: str) -> None:
    """MCR: a false rung toggles the override."""
    if power == "True":
        return
    with rungs.writer.block(f"if not ({power}):"):
        rungs.set_override(f"not {rungs.override}")
