"""The answer to "why" in at most six lines: the value and its time, the path to the cause, the cause.

    Lamp is off since 9 s (scan 4,500): Main rung 1: XIC(Run)
      because Run is off since 9 s: Main rung 0: XIC(Stop)
    Cause: Stop is off since 9 s: slot 2 input 1 (stop): The stop input is de-energized.

The last line is the end of `CauseLink.path`. The middle of a longer path is omitted; `deep` adds the chain.
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

MOST_WAY = 3
"""Maximum number of links shown between the value and the cause."""

MOST_VALUES = 4
"""Maximum number of values in a line."""

MOST_ALSO = 2
"""Maximum number of other causes in the last line."""

AT_REST = ("never", "setting", "timer")
"""Kinds of links whose text includes a time."""


def answer_text(link: CauseLink, *, deep: bool = False) -> str:
    """Return a chain as an answer of at most six lines; with `deep`, the whole chain follows."""
    path = link.path
    links = list(path[1:-1])
    lines = [_line("", link, _scan(link))]
    if len(links) > MOST_WAY:
        left = len(links) - MOST_WAY + 1
        lines += [
            _line("  because ", links[0]),
            f"  ... {left} links (--deep has all)",
            _line("  because ", links[-1]),
        ]
    else:
        lines += [_line("  because ", reason) for reason in links]
    if len(path) == 1:
        lines = []
    head = "Cause: " if lines else ""
    last = _whole(head, path[-1], "" if lines else _scan(link), _also(link))
    lines += _wrapped(last, MOST_LINES - len(lines))
    if deep:
        lines += [part for line in str(link).splitlines() for part in _folded(line)]
    return "\n".join(lines)


def _folded(line: str) -> list[str]:
    """Wrap a line of a chain into lines of readable length, with a hanging indent."""
    indent = " " * (len(line) - len(line.lstrip()) + 4)
    return wrap(line, LONGEST, subsequent_indent=indent, break_on_hyphens=False, break_long_words=False)


def _scan(link: CauseLink) -> str:
    return "" if link.kind in AT_REST or not link.scan else f" (scan {link.scan:,})"


def _also(link: CauseLink) -> str:
    """Return the other causes of the same kind and scan as the last one, which were also missing."""
    end = link.end
    others = [
        other
        for other in _ends(link)
        if other is not end and (other.kind, other.scan) == (end.kind, end.scan)
    ]
    names = list(dict.fromkeys(map(_state, others)))[:MOST_ALSO]
    return f"; and {', '.join(names)}" if names else ""


def _ends(link: CauseLink) -> Iterator[CauseLink]:
    """Yield the last links of the other causes that were needed along the path."""
    for stage in link.path:
        for group in stage.causes:
            if len(group) == 1 and group[0] not in link.path:
                yield group[0].end


def _line(head: str, link: CauseLink, scan: str = "") -> str:
    return _cut(_whole(head, link, scan))


def _whole(head: str, link: CauseLink, scan: str = "", also: str = "") -> str:
    when = f"{seconds(link.now_ns)} s{scan}"
    if link.kind == "wait":
        site = link.site
        where = f": {site.spot}: {site.instruction}" if site is not None else ""
        if link.text.startswith("waits for "):
            return f"{head}{link.name} {link.text} since {when}{where}{also}"
        return f"{head}{link.name} continued at {when}: {_place(link)}{also}"
    since = "" if _says_when(link) else f" since {when}"
    place = " ".join(_place(link).split())
    return f"{head}{_state(link)}{since}{': ' if place else ''}{place}{also}"


def _says_when(link: CauseLink) -> bool:
    return link.kind in AT_REST or link.value is None or (not link.scan and "never" in link.text)


def _cut(text: str) -> str:
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."


def _wrapped(text: str, most: int) -> list[str]:
    """Wrap a text into at most `most` lines."""
    lines = wrap(text, LONGEST, subsequent_indent="    ", break_on_hyphens=False)
    return (
        lines
        if len(lines) <= most
        else [*lines[: most - 1], _cut(lines[most - 1] + " " + lines[most].strip())]
    )


def _state(link: CauseLink) -> str:
    value = link.value
    if value is None:
        return link.name
    if isinstance(value, str):
        return f"{link.name} is {value!r}"
    if isinstance(value, bool):
        return f"{link.name} is {('off', 'on')[value]}"
    return f"{link.name} is {value}"


def _place(link: CauseLink) -> str:
    site = link.site
    where = (
        ""
        if site is None
        else site.spot
        if site.file and not site.routine
        else f"{site.routine} {site.place}"
    )
    return ": ".join(filter(None, (where, link.text))) + _values(link)


def _values(link: CauseLink) -> str:
    """Return the values that a line of Python read, as ` [state.step = 'first']`."""
    read = link.operands[:MOST_VALUES] if link.kind == "line" else ()
    listed = ", ".join(f"{operand.name} = {shown(operand.value)}" for operand in read)
    return f" [{listed}]" if listed else ""
