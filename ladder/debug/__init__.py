"""Working on a running program: watch it, stop it, force it, and ask it why."""

from .crossref import CrossReference, Mention, cross_reference
from .debugger import Debugger, Stop
from .watched import Blocker, Change

__all__ = ["Blocker", "Change", "CrossReference", "Debugger", "Mention", "Stop", "cross_reference"]
