"""Debugging a running program: observe, stop, force, and explain."""

from .answer_text import answer_text
from .chains import Chains
from .crossref import CrossReference, Mention, cross_reference
from .debugger import BreakpointStop, Debugger
from .links import CauseLink, Operand, linked
from .remedies import Remedies
from .watched import Blocker, Change

__all__ = [
    "Blocker",
    "BreakpointStop",
    "CauseLink",
    "Chains",
    "Change",
    "CrossReference",
    "Debugger",
    "Mention",
    "Operand",
    "Remedies",
    "answer_text",
    "cross_reference",
    "linked",
]
