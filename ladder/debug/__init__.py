"""Debugging a running program: observe, stop, force, and ask for causes."""

from .crossref import CrossReference, Mention, cross_reference
from .debugger import BreakpointStop, Debugger
from .watched import Blocker, Change

__all__ = ["Blocker", "BreakpointStop", "Change", "CrossReference", "Debugger", "Mention", "cross_reference"]
