"""Reads and writes programs in `.rung`, `.st` and `.steps` files."""

from __future__ import annotations

TYPE_CHECKING = False  # type checkers assume that it is true

if TYPE_CHECKING:  # type checkers import these lines, `__getattr__` reads them
    from .rungfile import parse_program, parse_structured, program_text


def __getattr__(name: str) -> object:
    from scanrack.io_images.front_door import listed_in

    return listed_in(__spec__, name)
