"""The last change of a value in a long past, searched in many stretches at once.

`search` runs stretches side by side, `translation` makes a program of arrays, `vectors` is what it calls.
"""

from .search import Lanes

__all__ = ["Lanes"]
