"""The instructions as Python functions: `OTE(run)`, `TON(fill, 5000)`, `MOV(count.ACC, total)`.

Each takes its operands in the order of the rung text and returns the instruction; an
operand is a tag, a number, or an address as text. AND, OR and NOT are here as instructions.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from .front import make

if TYPE_CHECKING:
    from collections.abc import Callable

    from .tree import Instruction


def _instruction(name: str) -> Callable[..., Instruction]:
    return partial(make, name)


XIC = _instruction("XIC")
XIO = _instruction("XIO")
OTE = _instruction("OTE")
OTL = _instruction("OTL")
OTU = _instruction("OTU")
ONS = _instruction("ONS")
OSR = _instruction("OSR")
OSF = _instruction("OSF")
TON = _instruction("TON")
TOF = _instruction("TOF")
RTO = _instruction("RTO")
CTU = _instruction("CTU")
CTD = _instruction("CTD")
RES = _instruction("RES")
CMP = _instruction("CMP")
EQU = _instruction("EQU")
GEQ = _instruction("GEQ")
GRT = _instruction("GRT")
LEQ = _instruction("LEQ")
LES = _instruction("LES")
LIM = _instruction("LIM")
MEQ = _instruction("MEQ")
NEQ = _instruction("NEQ")
CPT = _instruction("CPT")
ADD = _instruction("ADD")
SUB = _instruction("SUB")
MUL = _instruction("MUL")
DIV = _instruction("DIV")
MOD = _instruction("MOD")
SQR = _instruction("SQR")
NEG = _instruction("NEG")
ABS = _instruction("ABS")
MOV = _instruction("MOV")
MVM = _instruction("MVM")
BTD = _instruction("BTD")
CLR = _instruction("CLR")
SWPB = _instruction("SWPB")
AND = _instruction("AND")
OR = _instruction("OR")
XOR = _instruction("XOR")
NOT = _instruction("NOT")
COP = _instruction("COP")
CPS = _instruction("CPS")
FLL = _instruction("FLL")
JMP = _instruction("JMP")
LBL = _instruction("LBL")
JSR = _instruction("JSR")
RET = _instruction("RET")
SBR = _instruction("SBR")
TND = _instruction("TND")
MCR = _instruction("MCR")
AFI = _instruction("AFI")
NOP = _instruction("NOP")
TRN = _instruction("TRN")

__all__ = [
    "ABS",
    "ADD",
    "AFI",
    "AND",
    "BTD",
    "CLR",
    "CMP",
    "COP",
    "CPS",
    "CPT",
    "CTD",
    "CTU",
    "DIV",
    "EQU",
    "FLL",
    "GEQ",
    "GRT",
    "JMP",
    "JSR",
    "LBL",
    "LEQ",
    "LES",
    "LIM",
    "MCR",
    "MEQ",
    "MOD",
    "MOV",
    "MUL",
    "MVM",
    "NEG",
    "NEQ",
    "NOP",
    "NOT",
    "ONS",
    "OR",
    "OSF",
    "OSR",
    "OTE",
    "OTL",
    "OTU",
    "RES",
    "RET",
    "RTO",
    "SBR",
    "SQR",
    "SUB",
    "SWPB",
    "TND",
    "TOF",
    "TON",
    "TRN",
    "XIC",
    "XIO",
    "XOR",
]
