"""The possible values of an expression, one by one: a constant, or each element of a table."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple


class Choices(NamedTuple):
    """The possible values of an expression or of a word, called options.

    Attributes:
        options: the options; empty if they are unknown.
        source: where they come from, such as a table. Options of one source vary together.
        names: a name for each option, for messages.
    """

    options: tuple[Any, ...] = ()
    source: str = ""
    names: tuple[str, ...] = ()

    def at(self, place: int) -> Any:
        """Return an option by its place; a single option has every place."""
        return self.options[place if len(self.options) > 1 else 0]


UNKNOWN_CHOICES = Choices()


def combined(parts: Sequence[Choices], of: Callable[..., Any]) -> Choices:
    """Apply a function to options; unknown if a part is unknown, if sources differ, or if the call fails."""
    several = [part for part in parts if len(part.options) > 1]
    if len({choices.source for choices in several}) > 1:
        return UNKNOWN_CHOICES
    rows = range(min((len(choices.options) for choices in several), default=1))
    try:
        results = tuple(of(*(part.at(place) for part in parts)) for place in rows)
    except (TypeError, ValueError, ArithmeticError, LookupError, AttributeError):
        return UNKNOWN_CHOICES
    first, *_ = *several, UNKNOWN_CHOICES
    return first._replace(options=results)
