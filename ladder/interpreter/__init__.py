"""The interpreter: the reference for the compiled program."""

from .interpreter import Interpreter
from .values import PlaceValues

__all__ = ["Interpreter", "PlaceValues"]
