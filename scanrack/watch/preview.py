"""Makes the preview of an edit: its difference, its mistakes by line, and what it would do.

    diff       +  12  XIC(Go)OTX(Lamp);
    mistake       12  no instruction OTX
    groups     restart: Size; new: Count

Pages show the preview; nothing changes until a page takes the edit over.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from difflib import SequenceMatcher
from pathlib import Path
from typing import Any

from scanrack.io_images.site import Site, SiteError, sites_of
from scanrack.jobs.check import check_rack
from scanrack.jobs.load.loading import LoadedRack
from scanrack.jobs.prove.serving.effects import Group
from scanrack.jobs.run.editing import DescribedEdit
from scanrack.ladder.model.errors import BuildError
from scanrack.ladder.python.online.field_plan import EditRefusal

Json = dict[str, Any]

NEAR = 3
"""Number of unchanged lines shown before and after a change."""

MOST_ROWS = 600
"""Largest number of lines of a difference that a page receives."""

MOST_COMPARED = 4_000_000
"""Changed parts are compared line by line up to this product of their numbers of lines."""

MOST_NAMES = 200
"""Largest number of names in a group that a page receives."""


def mistake_of(error: Exception, program: Path) -> Json:
    """Return a mistake for a page: its text, the program's file, and its line if known.

    >>> from scanrack.io_images.site import Site, SiteError
    >>> mistake_of(SiteError.at(Site(file="demo.rung", line=12), "no tag Rum"), Path("demo.rung"))
    {'text': 'demo.rung:12: no tag Rum', 'file': 'demo.rung', 'line': 12}
    """
    lines = (site.line for site in sites_of(error) if Path(site.file).name == program.name)
    line = next(filter(None, lines), None)
    restarts = {"restart": list(error.sequences)} if isinstance(error, EditRefusal) else {}
    return {"text": str(error), "file": program.name, "line": line, **restarts}


def mistakes_of(error: Exception, program: Path) -> list[Json]:
    """Return each mistake of an edit as `mistake_of` does, but without its place in the text."""
    for cause in reversed(list(_causes(error))):  # the rack file's error only names the unusable program
        if isinstance(cause, EditRefusal):
            return _refusals(cause, program)
        if isinstance(cause, BuildError):
            return [
                _mistake(f"{problem.text}; {problem.remedy}", problem.site, program)
                for problem in cause.problems
            ]
        if isinstance(cause, SiteError) and cause.sites:
            return [_mistake(cause.reason, cause.site, program)]
    return [mistake_of(error, program)]


def _causes(error: BaseException | None) -> Iterator[BaseException]:
    while error is not None:
        yield error
        error = error.__cause__


def _refusals(error: EditRefusal, program: Path) -> list[Json]:
    """Return why each sequence can't continue; `old` is the line of the running program where it waits."""
    restart = list(error.sequences)
    if not error.refusals:
        return [{**_mistake(error.reason, error.site, program), "restart": restart}]
    return [
        {
            "text": refusal.reason,
            "file": program.name,
            "line": None,
            "old": refusal.site.line,
            "restart": restart,
        }
        for refusal in error.refusals
    ]


def _mistake(text: str, site: Site, program: Path) -> Json:
    is_own_file = Path(site.file).name in ("", program.name)
    return {"text": text, "file": program.name, "line": site.line if is_own_file else None}


def findings_of(job: LoadedRack) -> list[Json]:
    """Return the findings of `scanrack check` in a program's own file: line, rule and sentence."""
    return [
        {"line": finding.place.line, "rule": finding.rule, "text": f"{finding.text}; {finding.row.remedy}"}
        for finding in check_rack(job).findings
        if Path(finding.place.file).name == job.program.name
    ]


def new_findings(found: Iterable[Json], known: Iterable[Json]) -> list[Json]:
    """Return the findings that an earlier version did not have, ignoring line numbers."""
    remaining = [(finding["rule"], finding["text"]) for finding in known]
    fresh = []
    for finding in found:
        if (finding["rule"], finding["text"]) in remaining:
            remaining.remove((finding["rule"], finding["text"]))
        else:
            fresh.append(finding)
    return fresh


def preview_of(
    program: Path,
    texts: tuple[str, str],
    *,
    edit: DescribedEdit | None = None,
    mistakes: Iterable[Json] = (),
    findings: Iterable[Json] = (),
    effects: Iterable[Group] = (),
) -> Json:
    """Return a preview for a page.

    Args:
        program: file of the program.
        texts: the running text and the edited text.
        edit: effects of the edit; None if it can't be taken over.
        mistakes: the reasons for that, as from `mistakes_of`.
        findings: findings of `check` that the running program does not have.
        effects: what the edit can change in any run, by kind.
    """
    refusals, noted = list(mistakes), list(findings)
    marked = {("new", finding["line"]) for finding in (*refusals, *noted)} | {
        ("old", refusal.get("old")) for refusal in refusals
    }
    rows = rows_of(*texts, marked)
    sections = () if edit is None else (*edit.groups, *effects)
    groups = [(title, list(names)) for title, names in sections if names]
    return {
        "file": program.name,
        "rows": rows[:MOST_ROWS],
        "more": max(0, len(rows) - MOST_ROWS),
        "mistakes": refusals,
        "findings": noted,
        "keeps": "" if edit is None else edit.keeps,
        "groups": [{"title": title, "names": names[:MOST_NAMES]} for title, names in groups],
        "restart": next((refusal["restart"] for refusal in refusals if refusal.get("restart")), []),
    }


def rows_of(before: str, after: str, marked: Iterable[tuple[str, int | None]] = ()) -> list[Json]:
    r"""Return the lines of a difference, and those near marked lines.

    A row has `sign` (" ", "+", "-"), `old` and `new` line numbers, from 1, or None, and its `text`. A row
    without a text stands for omitted lines. A marked line is `("new", 12)`, or `("old", 12)` for a line of
    the first text.

    >>> [(row["sign"], row["new"], row["text"]) for row in rows_of("a\nb", "a\nc")]
    [(' ', 1, 'a'), ('-', None, 'b'), ('+', 2, 'c')]
    """
    rows, lines = list(_rows(before.splitlines(), after.splitlines())), set(marked)
    shown_places: set[int] = set()
    for place, row in enumerate(rows):
        if row["sign"] != " ":
            shown_places.update(range(place - NEAR, place + NEAR + 1))
        if lines & {("old", row["old"]), ("new", row["new"])}:
            shown_places.update(range(place - 1, place + 2))
    listed: list[Json] = []
    for place, row in enumerate(rows):
        if place in shown_places:
            listed.append(row)
        elif listed and listed[-1]["text"] is not None:
            listed.append({"sign": " ", "old": None, "new": None, "text": None})
    return listed[:-1] if listed and listed[-1]["text"] is None else listed


def _rows(before: list[str], after: list[str]) -> Iterator[Json]:
    """Yield all lines of both texts in the order of a diff."""
    for tag, first, last, start, end in _changes(before, after):
        if tag == "equal":
            for number in range(last - first):
                yield _row(" ", first + number + 1, start + number + 1, before[first + number])
            continue
        for number in range(first, last):
            yield _row("-", number + 1, None, before[number])
        for number in range(start, end):
            yield _row("+", None, number + 1, after[number])


def _row(sign: str, old: int | None, new: int | None, text: str) -> Json:
    return {"sign": sign, "old": old, "new": new, "text": text}


def _changes(before: list[str], after: list[str]) -> Iterator[tuple[str, int, int, int, int]]:
    """Yield equal and changed parts; find the equal ends first, so that a small edit is cheap."""
    most = min(len(before), len(after))
    head = next((n for n in range(most) if before[n] != after[n]), most)
    tail = next((n for n in range(most - head) if before[-1 - n] != after[-1 - n]), most - head)
    old_middle, new_middle = before[head : len(before) - tail], after[head : len(after) - tail]
    yield "equal", 0, head, 0, head
    if len(old_middle) * len(new_middle) > MOST_COMPARED:
        yield "replace", head, head + len(old_middle), head, head + len(new_middle)
    else:
        for tag, first, last, start, end in SequenceMatcher(None, old_middle, new_middle).get_opcodes():
            yield tag, head + first, head + last, head + start, head + end
    yield "equal", len(before) - tail, len(before), len(after) - tail, len(after)
