"""What a value may be, one option after the other: a constant, or each element of a table."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple


class Choices(NamedTuple):
    """The options of an expression, or of a word.

    Attributes:
        options: none if they are unknown.
        source: where they come from, such as a table; values of one source get those of one place together.
        names: what the source is for each option, for messages.
    """

    options: tuple[Any, ...] = ()
    source: str = ""
    names: tuple[str, ...] = ()

    def at(self, place: int) -> Any:
        """Return an option; of a single one, that."""
        return self.options[place if len(self.options) > 1 else 0]


UNKNOWN_CHOICES = Choices()


def combined(parts: Sequence[Choices], of: Callable[..., Any]) -> Choices:
    """Return a function of options; unknown if a part is, if the function fails, or of several sources."""
    several = [each for each in parts if len(each.options) > 1]
    if len({each.source for each in several}) > 1:
        return UNKNOWN_CHOICES
    rows = range(min((len(each.options) for each in several), default=1))
    try:
        results = tuple(of(*(each.at(place) for each in parts)) for place in rows)
    except (TypeError, ValueError, ArithmeticError, LookupError, AttributeError):
        return UNKNOWN_CHOICES
    first, *_ = *several, UNKNOWN_CHOICES
    return first._replace(options=results)
