"""The interpreter, and what the compiler shares with it."""

from .interpreter import Interpreter
from .numbers import COMPARISONS, COMPUTATIONS
from .timing import MS
from .values import width_of

__all__ = ["COMPARISONS", "COMPUTATIONS", "MS", "Interpreter", "width_of"]
