"""Trigonometric and advanced math instructions, and the conversions of angles.

They compute in LREAL if an operand or the destination is one, else in REAL. A result that is not finite
although the source is (ASN of 2, LN of 0) is an overflow: S:V and a minor fault 4/4.
"""

from __future__ import annotations

from ..spec import Spec, Use
from .compute import computation

__all__ = [  # noqa: RUF022 - the manual's order
    "SIN",
    "COS",
    "TAN",
    "ASN",
    "ACS",
    "ATN",
    "LN",
    "LOG",
    "XPY",
    "DEG",
    "RAD",
]


def _function(name: str) -> Spec:
    return computation(name, name.partition("/")[0], Use.NUMBER)


SIN = _function("SIN")
COS = _function("COS")
TAN = _function("TAN")
ASN = _function("ASN/ASIN")
ACS = _function("ACS/ACOS")
ATN = _function("ATN/ATAN")
LN = _function("LN")
LOG = _function("LOG")
XPY = computation("XPY/EXPT", "**", Use.NUMBER, Use.NUMBER)
DEG = _function("DEG")
RAD = _function("RAD")
