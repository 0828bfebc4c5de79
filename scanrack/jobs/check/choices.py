"""The individual values that an expression can have: a constant, or each element of a table."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple


class Choices(NamedTuple):
    """The possible values of an expression or of a word, called options.

    Attributes:
        options: the values; empty if they are unknown.
        source: the table or expression of the options. Options from one source vary together.
        names: a name for each option, for messages.
    """

    options: tuple[Any, ...] = ()
    source: str = ""
    names: tuple[str, ...] = ()

    def at(self, index: int) -> Any:
        """Return an option by its index; a single option is returned for every index."""
        return self.options[index if len(self.options) > 1 else 0]


UNKNOWN_CHOICES = Choices()


def combined(arguments: Sequence[Choices], function: Callable[..., Any]) -> Choices:
    """Return the results of a function for each option of its arguments.

    The result is unknown if an argument is unknown, if arguments vary with different sources, or if a call
    fails.
    """
    varying = [argument for argument in arguments if len(argument.options) > 1]
    if len({argument.source for argument in varying}) > 1:
        return UNKNOWN_CHOICES
    rows = range(min((len(argument.options) for argument in varying), default=1))
    try:
        results = tuple(function(*(argument.at(row) for argument in arguments)) for row in rows)
    except (TypeError, ValueError, ArithmeticError, LookupError, AttributeError):
        return UNKNOWN_CHOICES
    return (varying[0] if varying else UNKNOWN_CHOICES)._replace(options=results)
