"""Searches the last change of a value in a long past, in many stretches at once.

`search` runs stretches in parallel, `translation` turns a program into code on arrays, and `vectors` has the
functions that this code calls.
"""

from .search import Lanes

__all__ = ["Lanes"]
