"""Why a tag has its value: the chain of causes in the console, each link with its line."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

from .protocol import DebugError

if TYPE_CHECKING:
    from .adapter import Adapter

T = TypeVar("T")


def why(adapter: Adapter, tag: str) -> str:
    """Return why a tag has its value after the scan; the links follow, each with its line.

    Raises:
        DebugError: the tag does not exist, or is not a single value.
    """
    subject, scan = adapter.the_subject(), adapter.place().scan
    if tag not in adapter.place().view.tags:
        raise DebugError(f"no tag {tag!r}: write why TAG")
    links = _away(adapter, lambda: subject.why(tag, scan))
    for text, origin in links[1:]:
        adapter.output(f"  <- {text}\n", more=subject.places(scan).source(origin))
    return links[0][0]


def last_change(adapter: Adapter, tag: str) -> int | None:
    """Return the last scan, up to the current one, that changed a tag; None if there is none."""
    scan = adapter.place().scan
    return _away(adapter, lambda: adapter.the_subject().last_change(tag, scan))


def _away(adapter: Adapter, search: Callable[[], T]) -> T:
    """Return the result of a search in the past; then restore the client's position."""
    cursor = adapter.place()
    scan, spot = cursor.scan, cursor.spot
    adapter.leave()
    try:
        return search()
    finally:
        adapter.look_at(scan).go(spot)
