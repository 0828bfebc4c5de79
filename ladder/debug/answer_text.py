"""The answer to "why" in at most six lines: the value and its time, then the path to the cause.

    Lamp is off since 9 s (scan 4,500): Main rung 1: XIC(Run)
      because Run is off since 9 s: Main rung 0: XIC(Stop)
    Cause: Stop is off since 9 s: slot 2 input 1 (stop): The stop input is de-energized.

The last line is the end of `CauseLink.path`. The middle of a longer path is omitted.
"""

from __future__ import annotations

from collections.abc import Iterator
from textwrap import wrap

from scanrack.io_images.times import seconds

from .links import CauseLink
from .watched import shown

LONGEST = 110
"""Maximum length of a line, in characters."""

MOST_LINES = 6
"""Maximum number of lines of an answer."""

MOST_REASONS = 3
"""Maximum number of links shown between the value and the cause."""

MOST_VALUES = 4
"""Maximum number of values in a line."""

MOST_ALSO = 2
"""Maximum number of other causes in the last line."""

AT_REST = ("never", "setting", "timer")
"""Kinds of links whose text already includes a time."""


def answer_text(link: CauseLink, *, deep: bool = False) -> str:
    """Return a chain as an answer of at most six lines; if `deep`, append the whole chain."""
    path = link.path
    links = list(path[1:-1])
    lines = [_line("", link, _scan_text(link))]
    if len(links) > MOST_REASONS:
        omitted = len(links) - MOST_REASONS + 1
        lines += [
            _line("  because ", links[0]),
            f"  ... {omitted} links (--deep shows all)",
            _line("  because ", links[-1]),
        ]
    else:
        lines += [_line("  because ", reason) for reason in links]
    if len(path) == 1:
        lines = []
    head = "Cause: " if lines else ""
    last = _full_line(head, path[-1], "" if lines else _scan_text(link), _other_causes(link))
    lines += _wrapped(last, MOST_LINES - len(lines))
    if deep:
        lines += [part for line in str(link).splitlines() for part in _folded(line)]
    return "\n".join(lines)


def _folded(line: str) -> list[str]:
    """Wrap a line of a chain to a readable length, with a hanging indent."""
    indent = " " * (len(line) - len(line.lstrip()) + 4)
    return wrap(line, LONGEST, subsequent_indent=indent, break_on_hyphens=False, break_long_words=False)


def _scan_text(link: CauseLink) -> str:
    """Return a link's scan as text; "" if its own text has the time, or for scan 0."""
    return "" if link.kind in AT_REST or not link.scan else f" (scan {link.scan:,})"


def _other_causes(link: CauseLink) -> str:
    """Return other causes of the same kind and scan as the last link, as text; "" if there are none."""
    end = link.end
    other_ends = [
        other_end
        for other_end in _ends(link)
        if other_end is not end and (other_end.kind, other_end.scan) == (end.kind, end.scan)
    ]
    names = list(dict.fromkeys(map(_state, other_ends)))[:MOST_ALSO]
    return f"; and {', '.join(names)}" if names else ""


def _ends(link: CauseLink) -> Iterator[CauseLink]:
    """Yield the last links of other causes that were also needed along the path."""
    for stage in link.path:
        for group in stage.causes:
            if len(group) == 1 and group[0] not in link.path:
                yield group[0].end


def _line(head: str, link: CauseLink, scan: str = "") -> str:
    """Return the line of a link, cut to `LONGEST` characters."""
    return _cut(_full_line(head, link, scan))


def _full_line(head: str, link: CauseLink, scan: str = "", also: str = "") -> str:
    """Return the line of a link, uncut: its value or wait, time, place and text; `also` comes last."""
    time_text = f"{seconds(link.now_ns)} s{scan}"
    if link.kind == "wait":
        site = link.site
        place = f": {site.spot}: {site.instruction}" if site is not None else ""
        if link.text.startswith("waits for "):
            return f"{head}{link.name} {link.text} since {time_text}{place}{also}"
        return f"{head}{link.name} continued at {time_text}: {_place_and_text(link)}{also}"
    since = "" if _includes_time(link) else f" since {time_text}"
    place = " ".join(_place_and_text(link).split())
    return f"{head}{_state(link)}{since}{': ' if place else ''}{place}{also}"


def _includes_time(link: CauseLink) -> bool:
    """Return whether a link needs no `since`: its text has the time or says never, or it has no value."""
    return link.kind in AT_REST or link.value is None or (not link.scan and "never" in link.text)


def _cut(text: str) -> str:
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."


def _wrapped(text: str, most: int) -> list[str]:
    """Wrap a text into at most `most` lines."""
    lines = wrap(text, LONGEST, subsequent_indent="    ", break_on_hyphens=False)
    if len(lines) <= most:
        return lines
    return [*lines[: most - 1], _cut(lines[most - 1] + " " + lines[most].strip())]


def _state(link: CauseLink) -> str:
    """Return the name and value of a link, such as `Lamp is off`; the name alone without a value."""
    value = link.value
    if value is None:
        return link.name
    if isinstance(value, str):
        return f"{link.name} is {value!r}"
    if isinstance(value, bool):
        return f"{link.name} is {('off', 'on')[value]}"
    return f"{link.name} is {value}"


def _place_and_text(link: CauseLink) -> str:
    """Return the place, text and values of a link, such as `Main rung 0: XIC(Stop)`."""
    site = link.site
    place = ""
    if site is not None:
        in_python = site.file and not site.routine
        place = site.spot if in_python else f"{site.routine} {site.place}"
    return ": ".join(filter(None, (place, link.text))) + _values(link)


def _values(link: CauseLink) -> str:
    """Return the values that a line of Python read, in the form ` [state.step = 'first']`."""
    read = link.operands[:MOST_VALUES] if link.kind == "line" else ()
    listed = ", ".join(f"{operand.name} = {shown(operand.value)}" for operand in read)
    return f" [{listed}]" if listed else ""
