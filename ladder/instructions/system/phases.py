"""Equipment phases and sequences [LOGIX-UM001, 1756-RM003N].

The simulation has no phase manager. Instructions return result 24594, "phase not scheduled", and phases keep
their states. PSC, PPD, PRNP and other instructions without a result do nothing.
"""

from __future__ import annotations

from ...interpreter import Interpreter
from ...model.operands import Place, Resolved
from ...model.spec import Spec, Use, action, do_nothing
from ...state.regions import converted

NOT_SCHEDULED = 24594
"""Result when a phase is not scheduled, or it or its task is inhibited."""


def _run(machine: Interpreter, *operands: Resolved | str) -> None:
    result = operands[-1] if operands else None
    if isinstance(result, Place) and result.type.is_integer:
        machine.put(result, converted(result.type, NOT_SCHEDULED))


def _row(name: str, *operands: Use) -> Spec:
    with_result = Use.OPTIONAL_TARGET in operands
    return action(name, *operands, run=_run if with_result else do_nothing)


PSC = _row("PSC")
PCMD = _row("PCMD", Use.LABEL, Use.LABEL, Use.OPTIONAL_TARGET)
PCLF = _row("PCLF", Use.LABEL)
PXRQ = _row("PXRQ", Use.IGNORED, Use.LABEL, Use.IGNORED)
PRNP = _row("PRNP")
PPD = _row("PPD")
PATT = _row("PATT", Use.LABEL, Use.OPTIONAL_TARGET)
PDET = _row("PDET", Use.LABEL)
PFL = _row("PFL", Use.NUMBER)
POVR = _row("POVR", Use.LABEL, Use.LABEL, Use.OPTIONAL_TARGET)
SATT = _row("SATT", Use.LABEL, Use.OPTIONAL_TARGET)
SDET = _row("SDET", Use.LABEL)
SCMD = _row("SCMD", Use.LABEL, Use.LABEL, Use.OPTIONAL_TARGET)
SCLF = _row("SCLF", Use.LABEL)
SOVR = _row("SOVR", Use.LABEL, Use.LABEL, Use.OPTIONAL_TARGET)
SASI = _row("SASI", Use.LABEL, Use.IGNORED, Use.OPTIONAL_TARGET)
