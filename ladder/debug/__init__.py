"""Working on a running program: watch it, stop it, force it, and ask it why."""

from .crossref import CrossReference, Mention, cross_reference
from .debugger import BreakpointStop, Debugger
from .watched import Blocker, Change

__all__ = ["Blocker", "BreakpointStop", "Change", "CrossReference", "Debugger", "Mention", "cross_reference"]
