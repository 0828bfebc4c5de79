"""Fields of a page's questions. A ValueError describes a mistake in a question."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..history.catalog import COLUMNS
from ..history.stretch import Stretch
from ..history.strip import piece_of
from .monitor import Json, Monitor
from .page import Page

Question = Mapping[str, Any]
"""A question from a page: an object with the keys `id` and `do`, and other fields."""

SCANS_MOST = 50_000
"""Maximum number of scans in a question."""

ENVELOPE_STEPS = 500
"""Number of points of a position in a window of past scans."""


def program_of(monitor: Monitor, page: Page) -> Stretch:
    """Return the program that a page shows."""
    return page.program or monitor.subject.programs.latest


def name_in_program(monitor: Monitor, page: Page, tag: str) -> str:
    """Return the name of a tag in a ladder program: an address instead of `slot1.status.IN_HOME`."""
    catalog = program_of(monitor, page).catalog
    if catalog is None or catalog.has(tag):
        return tag
    return addresses_in(monitor, page, [tag]).get(tag, tag)


def addresses_in(monitor: Monitor, page: Page, tags: Sequence[str]) -> dict[str, str]:
    """Return the addresses of the tags that refer to a word or bit of an image."""
    program = program_of(monitor, page)
    addresses = {} if program.catalog is None else program.catalog.addresses(tags)
    for tag in tags:
        address = program.address(tag)
        if address is not None:
            addresses[tag] = str(address)
    return addresses


def text_in(question: Question, key: str) -> str:
    """Return a text in a question."""
    value = question.get(key)
    if not _is_name(value):
        raise ValueError(f"{key} must be text of 1 to 400 characters")
    return str(value)


def names_in(question: Question, most: int) -> list[str]:
    """Return the names of tags in a question."""
    tags = question.get("tags")
    if not isinstance(tags, list) or len(tags) > most or not all(map(_is_name, tags)):
        raise ValueError(f"tags must be a list of up to {most} names")
    return tags


def _is_name(value: object) -> bool:
    return isinstance(value, str) and 0 < len(value) <= 400


def scans_in(question: Question) -> tuple[int, int]:
    """Return the first and last scan of a question."""
    first, last = question.get("from"), question.get("to")
    if type(first) is not int or type(last) is not int or not 0 <= first <= last < first + SCANS_MOST:
        raise ValueError(f"from and to must be scan numbers, at most {SCANS_MOST:,} scans apart")
    return first, last


def step_in(question: Question) -> tuple[int, int]:
    """Return the scan from which a question searches, and the direction: 1 forwards, -1 backwards."""
    scan, direction = question.get("from"), question.get("way")
    if type(scan) is not int or direction not in (1, -1):
        raise ValueError("from must be a scan number, and way 1 or -1")
    return scan, direction


def columns_in(question: Question) -> int:
    """Return the width of drawn rungs, columns."""
    columns = question.get("columns", 88)
    if type(columns) is not int or columns not in COLUMNS:
        raise ValueError(f"columns {columns!r}: must be {COLUMNS[0]} to {COLUMNS[-1]}")
    return columns


def strip_in(monitor: Monitor, question: Question) -> Json:
    """Return the strip of the scans in a question, as far as available."""
    subject = monitor.subject
    rows = subject.timeline.between(*scans_in(question))
    return piece_of(
        rows,
        rows[:0],
        subject.signals,
        subject.spec.scan_ns,
        ENVELOPE_STEPS,
        formats=monitor.states.formats,
    )
