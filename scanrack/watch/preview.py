"""The preview of an edit: changed lines, mistakes by line, and effects.

    rows       +  12  XIC(Go)OTX(Lamp);
    mistake       12  no instruction OTX
    groups     restart: Size; new: Count

Pages show the preview. The program changes only when a page accepts the edit.
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
"""Maximum number of diff lines that a page gets."""

MOST_COMPARED = 4_000_000
"""Maximum product of the line counts of two changed parts to compare line by line."""

MOST_NAMES = 200
"""Maximum number of names in a group that a page gets."""


def mistake_of(error: Exception, program: Path) -> Json:
    """Return a mistake for a page: its text, the program's file, and the line or None.

    >>> from scanrack.io_images.site import Site, SiteError
    >>> mistake_of(SiteError.at(Site(file="demo.rung", line=12), "no tag Rum"), Path("demo.rung"))
    {'text': 'demo.rung:12: no tag Rum', 'file': 'demo.rung', 'line': 12}
    """
    lines = (site.line for site in sites_of(error) if Path(site.file).name == program.name)
    line = next(filter(None, lines), None)
    restarts = {"restart": list(error.sequences)} if isinstance(error, EditRefusal) else {}
    return {"text": str(error), "file": program.name, "line": line, **restarts}


def mistakes_of(error: Exception, program: Path) -> list[Json]:
    """Return all mistakes in an edit for a page, with texts that do not begin with the line."""
    for cause in reversed(list(_causes(error))):  # the outermost error only names the program
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
    """Return why each sequence can't continue; `old` is the line of the running program at which it waits."""
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
    """Return the findings of `scanrack check` in the program's file: line, rule and text."""
    return [
        {"line": finding.place.line, "rule": finding.rule, "text": f"{finding.text}; {finding.row.remedy}"}
        for finding in check_rack(job).findings
        if Path(finding.place.file).name == job.program.name
    ]


def new_findings(findings: Iterable[Json], earlier: Iterable[Json]) -> list[Json]:
    """Return the findings that an earlier version did not have, ignoring line numbers."""
    remaining = [(finding["rule"], finding["text"]) for finding in earlier]
    fresh = []
    for finding in findings:
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
        program: the program's file.
        texts: the running text and the edited text.
        edit: effects of the edit; None if it can't be used.
        mistakes: why the edit can't be used, from `mistakes_of`.
        findings: findings of `scanrack check` that the running program does not have.
        effects: possible effects of the edit in any run, by kind.
    """
    refusals, noted = list(mistakes), list(findings)
    marked = {("new", finding["line"]) for finding in (*refusals, *noted)}
    marked |= {("old", refusal.get("old")) for refusal in refusals}
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


def rows_of(old_text: str, new_text: str, marked: Iterable[tuple[str, int | None]] = ()) -> list[Json]:
    r"""Return the changed and the marked lines of two texts, with the lines around them.

    A row has `sign` (" ", "+", "-"), line numbers `old` and `new`, from 1, or None, and `text`. A row without
    text replaces omitted lines. A marked line is `("old", 12)` for the old text, or `("new", 12)`.

    >>> [(row["sign"], row["new"], row["text"]) for row in rows_of("a\nb", "a\nc")]
    [(' ', 1, 'a'), ('-', None, 'b'), ('+', 2, 'c')]
    """
    rows, marked_lines = list(_rows(old_text.splitlines(), new_text.splitlines())), set(marked)
    shown: set[int] = set()
    for index, row in enumerate(rows):
        if row["sign"] != " ":
            shown.update(range(index - NEAR, index + NEAR + 1))
        if marked_lines & {("old", row["old"]), ("new", row["new"])}:
            shown.update(range(index - 1, index + 2))
    listed: list[Json] = []
    for index, row in enumerate(rows):
        if index in shown:
            listed.append(row)
        elif listed and listed[-1]["text"] is not None:
            listed.append({"sign": " ", "old": None, "new": None, "text": None})
    return listed[:-1] if listed and listed[-1]["text"] is None else listed


def _rows(old: list[str], new: list[str]) -> Iterator[Json]:
    """Yield all lines of both texts in the order of a diff."""
    for tag, old_start, old_end, new_start, new_end in _changes(old, new):
        if tag == "equal":
            for offset in range(old_end - old_start):
                yield _row(" ", old_start + offset + 1, new_start + offset + 1, old[old_start + offset])
            continue
        for index in range(old_start, old_end):
            yield _row("-", index + 1, None, old[index])
        for index in range(new_start, new_end):
            yield _row("+", None, index + 1, new[index])


def _row(sign: str, old: int | None, new: int | None, text: str) -> Json:
    return {"sign": sign, "old": old, "new": new, "text": text}


def _changes(old: list[str], new: list[str]) -> Iterator[tuple[str, int, int, int, int]]:
    """Yield equal and changed parts, as `SequenceMatcher.get_opcodes` does.

    Equal lines at both ends are found first, so that a small edit takes little time.
    """
    most = min(len(old), len(new))
    head = next((n for n in range(most) if old[n] != new[n]), most)
    tail = next((n for n in range(most - head) if old[-1 - n] != new[-1 - n]), most - head)
    old_middle, new_middle = old[head : len(old) - tail], new[head : len(new) - tail]
    yield "equal", 0, head, 0, head
    if len(old_middle) * len(new_middle) > MOST_COMPARED:
        yield "replace", head, head + len(old_middle), head, head + len(new_middle)
    else:
        for tag, *bounds in SequenceMatcher(None, old_middle, new_middle).get_opcodes():
            old_start, old_end, new_start, new_end = (head + bound for bound in bounds)
            yield tag, old_start, old_end, new_start, new_end
    yield "equal", len(old) - tail, len(old), len(new) - tail, len(new)
