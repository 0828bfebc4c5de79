"""The interpreter: the reference that the compiled program is compared with."""

from .interpreter import Interpreter
from .values import PlaceValues

__all__ = ["Interpreter", "PlaceValues"]
