"""Trigonometric and advanced math instructions, and the conversions of angles.

They compute in LREAL if an operand or the destination is LREAL, else in REAL. If the source is finite but the
result is not (ASN of 2, LN of 0), this is an overflow. An overflow sets S:V and causes a minor fault 4/4.
"""

from __future__ import annotations

import math

from ..interpreter import Interpreter
from ..model.operands import Place, Resolved, width_of
from ..model.spec import Spec, Use, action
from .compute import computation


def _function(name: str) -> Spec:
    return computation(name, name.partition("/")[0], Use.NUMBER)


def _atan2(machine: Interpreter, y: Resolved, x: Resolved, target: Place) -> None:
    width = width_of(y, x, target)
    machine.clear_flags()
    machine.store(target, math.atan2(machine.number(y, width), machine.number(x, width)))


SIN = _function("SIN")
COS = _function("COS")
TAN = _function("TAN")
ASN = _function("ASN/ASIN")
ACS = _function("ACS/ACOS")
ATN = _function("ATN/ATAN")
ATAN2 = action("ATAN2", Use.NUMBER, Use.NUMBER, Use.TARGET, run=_atan2, faults=False)
LN = _function("LN")
LOG = _function("LOG")
XPY = computation("XPY/EXPT", "**", Use.NUMBER, Use.NUMBER)
DEG = _function("DEG")
RAD = _function("RAD")
