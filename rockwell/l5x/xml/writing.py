"""Writes elements of an L5X with the texts and flags that Studio 5000 reads."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from lxml import etree

from .spans import escaped


def element(parent: Any, name: str, **attributes: str) -> Any:
    """Return a new element; it is the root if `parent` is None."""
    return etree.Element(name, attributes) if parent is None else etree.SubElement(parent, name, attributes)


def text_element(parent: Any, name: str, text: str) -> None:
    """Add an element with text, unless the text is empty."""
    if text:
        element(parent, name).text = cdata(text)


def cdata(text: str) -> Any:
    """Return text, as a CDATA section if possible."""
    text = escaped(text)
    return text if "]]>" in text else etree.CDATA(text)


def flag(on: bool) -> str:
    """Return the text of a Boolean attribute."""
    return "true" if on else "false"


def write_statements(parent: Any, lines: Iterable[str]) -> None:
    """Add lines of structured text to a routine or a part of a chart."""
    content = element(parent, "STContent")
    for number, line in enumerate(lines):
        element(content, "Line", Number=str(number)).text = cdata(line)
