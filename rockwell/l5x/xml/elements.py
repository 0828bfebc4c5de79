"""Texts, numbers and children of elements."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

_NUMBER = re.compile(r"[0-9]{1,9}")


def number_of(text: str) -> int | None:
    """Return an attribute's whole number of up to 9 digits, else None."""
    return int(text) if _NUMBER.fullmatch(text) else None


def text_of(element: Any) -> str:
    """Return the text of an element; if there are several languages, that of the first."""
    if element is None:
        return ""
    if not len(element):
        return (element.text or "").strip()
    first_child = next(iter(element), None)
    chosen = first_child if first_child is not None and isinstance(first_child.tag, str) else element
    return "".join(chosen.itertext()).strip()


_DIMS = re.compile(r"[0-9]{1,9}(?:[\s,]+[0-9]{1,9})*+")


def dims_in(text: str) -> tuple[int, ...]:
    """Return the dimensions in a text such as `4 3 2` or `4,3,2`; `0` and "" mean none."""
    lengths = tuple(map(int, _NUMBER.findall(text))) if _DIMS.fullmatch(text) else ()
    return lengths if any(lengths) else ()


def wrong_dims(text: str) -> str:
    """Return the text if it is not a list of dimensions, else ""."""
    return "" if not text or _DIMS.fullmatch(text) else text


def is_true(text: str) -> bool:
    """Return whether an attribute is true."""
    return text.lower() in ("true", "1")


def whole_in(text: str) -> int:
    """Return the whole number in an attribute; 0 for any other text."""
    return number_of(text) or 0


def children(element: Any, *path: str) -> Iterator[Any]:
    """Yield the children at the end of a path of names."""
    if element is None:
        return
    *outer, name = path
    for child in element.iterchildren(outer[0] if outer else name):
        if outer:
            yield from children(child, *path[1:])
        else:
            yield child


def defined(element: Any, *path: str) -> Iterator[Any]:
    """Yield the children of an element that a partial export defines."""
    yield from (child for child in children(element, *path) if child.get("Use") != "Reference")


def defined_routines(program: Any) -> Iterator[Any]:
    """Yield the routines that a partial export defines; context without content is only a reference.

    A routine with encoded content is left out.
    """
    for routine in defined(program, "Routines", "Routine"):
        has_content = any(str(part.tag).endswith("Content") for part in routine)
        if has_content or (routine.get("Use") != "Context" and routine.find("EncodedData") is None):
            yield routine


def line_of_text(element: Any) -> int:
    """Return the line of an element's text, after white space."""
    text = element.text or ""
    return int(element.sourceline or 0) + text[: len(text) - len(text.lstrip())].count("\n")
