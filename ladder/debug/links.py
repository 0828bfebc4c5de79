"""A chain of causes as data: links from a value back to the first cause.

    Lamp off <- Run off <- Stop on        each link with its time, its place, and the values it read

A link has groups of causes. Every group was needed; one cause in a group was enough. The shortest groups and
the shortest alternatives come first.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import chain
from typing import Any

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.site import NOWHERE, Site
from scanrack.io_images.times import seconds

from ..state.memory import Value

ROOTS = (
    "input",
    "module",
    "partner",
    "operator",
    "force",
    "mode",
    "timer",
    "setting",
    "incident",
    "power-up",
    "fault",
    "task",
    "unknown",
)
"""Kinds of links whose cause is not in the program."""


OUTRANKING = ("force", "mode", "fault", "incident")
"""Kinds of links that outrank the program."""

ROUND = "a round before"
"""Text at the end of a path that repeats because the machine was in the same state one cycle earlier."""

NESTED = 8
"""Maximum indentation of a chain as text, in spaces; only the last of the deeper links is shown."""


@dataclass(frozen=True, slots=True)
class Operand:
    """A value that was read."""

    name: str
    value: Value | str
    changed: bool  # since the previous run


@dataclass(frozen=True, slots=True, eq=False)
class CauseLink:
    """A change and its causes; where branches of a chain rejoin, they share the same object."""

    kind: str  # rung, line, wait, never (a value that has not changed), or one of `ROOTS`
    name: str  # the changed tag, terminal or Python name
    value: Value | str | None  # the value after the change
    scan: int
    now_ns: int  # time of the scan, ns since power-up
    text: str = ""  # the instruction or event of the change
    site: Site | None = None  # the place in the user's program; None outside the program
    operands: tuple[Operand, ...] = ()
    before: Value | str | None = None  # the value before the change; None if it is not known
    causes: tuple[tuple[CauseLink, ...], ...] = ()

    depth: int = 1  # number of links to the end, on the shortest path

    def walk(self) -> Iterator[CauseLink]:
        """Yield this link and all its causes, each once, nearest first."""
        visited, pending = set(), [self]
        while pending:
            link = pending.pop()
            if link not in visited:
                visited.add(link)
                yield link
                pending += [cause for group in reversed(link.causes) for cause in reversed(group)]

    @property
    def first(self) -> CauseLink:
        """The end of the shortest path."""
        link = self
        while link.causes:
            link = link.causes[0][0]
        return link

    @property
    def path(self) -> tuple[CauseLink, ...]:
        """The links from the value to its cause; each leads to an outranking cause, or else to the latest.

        The links of a cyclic machine repeat. Repeated links are omitted if the chain reaches the start of the
        cycles. If it does not, the path ends with the first repeated link, of kind "round".
        """
        links, earlier_links, visited = [self], list[CauseLink](), {self._key}
        link, repeated = self, None
        while link.causes:
            causes = chain.from_iterable(link.causes)
            link = max(causes, key=lambda cause: (cause.kind in OUTRANKING, cause.scan, -cause.depth))
            if link._key in visited:
                repeated = repeated or link
            else:
                visited.add(link._key)
                (earlier_links if repeated else links).append(link)
        if repeated is None:
            return tuple(links)
        is_root = link.kind in ROOTS and link.kind != "unknown"
        if earlier_links and link is earlier_links[-1] and is_root:
            return (*links, *earlier_links)
        round_before = f"{repeated.text}, as now: {ROUND}"
        return (*links, replace(repeated, kind="round", text=round_before, causes=(), depth=1))

    def path_json(self) -> list[dict[str, Any]]:
        """Return the links of `path` as JSON values, in order; the last one is the cause."""
        return [_as_json(replace(link, causes=()), {}) for link in self.path]

    @property
    def end(self) -> CauseLink:
        """The last link of `path`: the cause."""
        return self.path[-1]

    @property
    def _key(self) -> tuple[object, ...]:
        """The fields that identify a repeated link in a path: name, value, place and kind."""
        site = self.site
        place = None if site is None else (site.routine, site.rung, site.file, site.line)
        return self.name, self.value, place, self.kind

    @property
    def since(self) -> dict[str, Any]:
        """Scan and time of the value, and the last different value, as JSON values.

        The page and `--json` use this data, so the keys must not change. `last_different` is None if the
        value was never different. The value of a wait is its text.
        """
        last = None if self.before is None or not self.scan else {"scan": self.scan - 1, "value": self.before}
        value = self.text if self.kind == "wait" else self.value
        return {"scan": self.scan, "now_ns": self.now_ns, "value": value, "last_different": last}

    def as_json(self) -> list[dict[str, Any]]:
        """Return the links in the order of `walk` as JSON values; causes are indices in that list."""
        links = list(self.walk())
        numbers = {link: number for number, link in enumerate(links)}
        return [_as_json(link, numbers) for link in links]

    def __str__(self) -> str:
        return "\n".join(_lines(self, "", "", set()))


def _as_json(link: CauseLink, numbers: Mapping[CauseLink, int]) -> dict[str, Any]:
    """Return a link as JSON values; `numbers` has the indexes of links in the list of `as_json`."""
    site = link.site or NOWHERE
    place = {
        "program": site.program,
        "routine": site.routine,
        site.unit: site.rung,
        "instruction": site.instruction,
        "file": site.file,
        "file_line": site.line,
    }
    return {
        "kind": link.kind,
        "name": link.name,
        "value": link.value,
        "before": link.before,
        "scan": link.scan,
        "now_ns": link.now_ns,
        "site": {name: value for name, value in place.items() if value not in ("", None)},
        "text": link.text,
        "operands": [
            {"name": operand.name, "value": operand.value, "changed": operand.changed}
            for operand in link.operands
        ],
        "causes": [[numbers[cause] for cause in group] for group in link.causes],
    }


def kind_at(site: Site) -> str:
    """Return the kind of a link at a place of the program: rung or line."""
    return "rung" if site.unit == "rung" else "line"


def linked(groups: Iterable[tuple[CauseLink, ...]], **parts: Any) -> CauseLink:
    """Return a link with sorted causes; `parts` are its other fields."""
    causes = ordered(groups)
    return CauseLink(**parts, causes=causes, depth=1 + (causes[0][0].depth if causes else 0))


def ordered(groups: Iterable[tuple[CauseLink, ...]]) -> tuple[tuple[CauseLink, ...], ...]:
    """Return groups without duplicates, the shortest groups and the shortest alternatives first."""
    unique_groups: dict[tuple[CauseLink, ...], None] = {}
    for group in groups:
        unique = tuple(dict.fromkeys(sorted(group, key=lambda link: link.depth)))
        if unique:
            unique_groups.setdefault(unique)
    return tuple(sorted(unique_groups, key=lambda group: group[0].depth))


def link_text(link: CauseLink, routine: str = "") -> str:
    """Return a link as text: `Run off (20.002 s, rung 3: XIC(Stop))`; omit the routine if it is `routine`."""
    site = link.site
    time_text = f"{seconds(link.now_ns)} s"
    place = "" if site is None else site.spot if site.file and not site.routine else site.place
    if site is not None and site.routine and site.routine != routine:
        place = f"{site.routine} {place}"
    place_and_text = ": ".join(filter(None, (place, link.text)))
    return (
        f"{link.name} {_value(link.value)} ({', '.join(filter(None, (time_text, place_and_text)))})".replace(
            "  ", " "
        )
    )


def _value(value: Value | str | None) -> str:
    if value is None:
        return ""
    return ("off", "on")[value] if isinstance(value, bool) else f"= {value}"


def _lines(link: CauseLink, routine: str, indent: str, printed: set[CauseLink]) -> Iterator[str]:
    """Yield a chain as lines; single causes continue their line, and a printed link is not repeated."""
    line = f"{indent}{link_text(link, routine)}"
    while len(link.causes) == 1 and len(link.causes[0]) == 1 and link not in printed:
        printed.add(link)
        routine = link.site.routine if link.site else routine
        (link,) = link.causes[0]
        line += f" <- {link_text(link, routine)}"
    if link.causes and len(indent) > NESTED:
        yield f"{line} <- ... <- {link_text(link.first)}"
    elif link.causes and link in printed:
        yield f"{line} <- as above"
    else:
        yield line
        yield from _branches(link, routine, indent, printed)


def _branches(link: CauseLink, routine: str, indent: str, printed: set[CauseLink]) -> Iterator[str]:
    """Yield lines for the causes of a link: groups are joined by `and`, alternatives by `or`."""
    printed.add(link)
    routine = link.site.routine if link.site else routine
    for group_number, group in enumerate(link.causes):
        for number, cause in enumerate(group):
            word = "or " if number else "and " if group_number else ""
            first, *more_lines = _lines(cause, routine, f"{indent}    ", printed)
            yield f"{indent}  <- {word}{first.strip()}"
            yield from more_lines
