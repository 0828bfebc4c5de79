"""Texts, numbers and children of elements."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

_NUMBER = re.compile(r"[0-9]{1,9}")


def number_of(text: str) -> int | None:
    """Return the integer in an attribute; None for other text, or for more than 9 digits."""
    return int(text) if _NUMBER.fullmatch(text) else None


def text_of(element: Any) -> str:
    """Return the text of an element; if it is in several languages, return the first one."""
    if element is None:
        return ""
    if not len(element):
        return (element.text or "").strip()
    first_child = next(iter(element), None)
    chosen = first_child if first_child is not None and isinstance(first_child.tag, str) else element
    return "".join(chosen.itertext()).strip()


_DIMS = re.compile(r"[0-9]{1,9}(?:[\s,]+[0-9]{1,9})*+")


def dims_in(text: str) -> tuple[int, ...]:
    """Return the dimensions in a text such as `4 3 2` or `4,3,2`; () for `0` and ""."""
    lengths = tuple(map(int, _NUMBER.findall(text))) if _DIMS.fullmatch(text) else ()
    return lengths if any(lengths) else ()


def wrong_dims(text: str) -> str:
    """Return the text if it is not a list of dimensions, otherwise ""."""
    return "" if not text or _DIMS.fullmatch(text) else text


def is_true(text: str) -> bool:
    """Return whether an attribute is true."""
    return text.lower() in ("true", "1")


def whole_in(text: str) -> int:
    """Return the integer in an attribute; 0 for other text."""
    return number_of(text) or 0


def children(element: Any, *path: str) -> Iterator[Any]:
    """Yield the elements at the end of a path of names; yield nothing if the element is None."""
    if element is None:
        return
    name, *inner_path = path
    for child in element.iterchildren(name):
        if inner_path:
            yield from children(child, *inner_path)
        else:
            yield child


def defined(element: Any, *path: str) -> Iterator[Any]:
    """Yield the elements at the end of a path that the export defines, without references."""
    return (child for child in children(element, *path) if child.get("Use") != "Reference")


def defined_routines(program: Any) -> Iterator[Any]:
    """Yield the routines that the export defines, except encoded ones.

    In a partial export, a context routine without content is only a reference.
    """
    for routine in defined(program, "Routines", "Routine"):
        has_content = any(str(part.tag).endswith("Content") for part in routine)
        if has_content or (routine.get("Use") != "Context" and routine.find("EncodedData") is None):
            yield routine


def line_of_text(element: Any) -> int:
    """Return the line of the first character in an element's text that is not blank."""
    text = element.text or ""
    return int(element.sourceline or 0) + text[: len(text) - len(text.lstrip())].count("\n")
