"""The interpreter: the reference for the compiled program."""

from .interpreter import Interpreter
from .place_values import PlaceValues

__all__ = ["Interpreter", "PlaceValues"]
