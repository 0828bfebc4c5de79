"""Finds the last change of a value in a long past, by searching many stretches at once.

`search` runs stretches in parallel, `translation` turns a program into code that works on arrays, and
`vectors` has the functions that this code calls.
"""

from .search import Lanes

__all__ = ["Lanes"]
