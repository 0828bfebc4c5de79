"""A comparison as one HTML file: both versions side by side, with changed rungs drawn and differences marked.

It loads nothing and runs nothing: its content policy allows its own style sheet and no script. Every text
from the files is escaped, and characters without a glyph are printed as in Python.
"""

from __future__ import annotations

import base64
from collections import Counter
from collections.abc import Iterator, Sequence
from hashlib import sha256
from html import escape
from itertools import zip_longest

from scanrack.io_images.visible_text import visible

from .alignment import aligned
from .comparison import ADDED, CHANGED, MOVED, REMOVED, RENAMED, Comparison, Difference
from .outline import RUNG, Step
from .page_style import STYLE
from .pairing import tokens_of
from .rung_pictures import picture, pictures

MOST_PICTURES = 600
"""Maximum rungs that are drawn; the others are shown as text."""

MOST_ROWS = 200
"""Maximum lines of a difference on the page."""

MOST_CHARACTERS = 20_000
"""Maximum characters of a line on the page."""

SIGNS = {ADDED: "+", REMOVED: "−", CHANGED: "≠", MOVED: "↕", RENAMED: "→"}


def page_of(comparison: Comparison, old: str, new: str) -> str:
    """Return the page of a comparison; `old` and `new` are the names of the files."""
    digest = base64.b64encode(sha256(STYLE.encode()).digest()).decode()
    policy = f"default-src 'none'; style-src 'sha256-{digest}'; base-uri 'none'; form-action 'none'"
    title = f"{_shown(new)} against {_shown(old)}"
    return "\n".join(
        (
            '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">',
            f'<meta http-equiv="Content-Security-Policy" content="{policy}">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f"<title>{title}</title>\n<style>{STYLE}</style></head><body>",
            *_Page(comparison).parts(f"<span>{_shown(new)}</span> against <span>{_shown(old)}</span>"),
            "</body></html>\n",
        )
    )


def _shown(text: str) -> str:
    """Escape text from a file."""
    cut = text if len(text) <= MOST_CHARACTERS else f"{text[:MOST_CHARACTERS]}… {len(text):,} characters"
    return escape(visible(cut))


class _Page:
    def __init__(self, comparison: Comparison) -> None:
        self._comparison = comparison
        self._pictures = MOST_PICTURES
        self._groups = list(comparison.by_owner().items())

    def parts(self, title: str) -> Iterator[str]:
        yield f"<header><h1>{title}</h1>"
        yield f'<p class="summary">{_shown(self._comparison.summary)}</p>'
        if self._comparison.apart:
            notes = "".join(f"<li>{_shown(note)}</li>" for note in self._comparison.apart)
            yield f"<details><summary>not counted</summary><ul>{notes}</ul></details>"
        yield "</header>"
        if len(self._groups) > 1:
            yield from self._contents()
        yield "<main>"
        for number, (owner, differences) in enumerate(self._groups):
            yield f'<section id="s{number}"><h2>{_shown(owner or "Controller")}</h2>'
            yield from map(self._difference, differences)
            yield "</section>"
        yield "</main>"

    def _contents(self) -> Iterator[str]:
        yield '<nav aria-label="contents"><ol>'
        for number, (owner, differences) in enumerate(self._groups):
            counts = Counter(difference.kind for difference in differences)
            signs = "".join(
                f'<b class="{kind}" title="{kind}">{SIGNS[kind]}{count}</b>' for kind, count in counts.items()
            )
            yield f'<li><a href="#s{number}">{_shown(owner or "Controller")}</a> {signs}</li>'
        yield "</ol></nav>"

    def _difference(self, found: Difference) -> str:
        head = f'<h3><b class="{found.kind}">{SIGNS[found.kind]}</b> {_shown(found.heading)}</h3>'
        return f'<article class="{found.kind}">{head}{"".join(self._content(found))}</article>'

    def _content(self, found: Difference) -> Iterator[str]:
        if found.what == RUNG and found.kind == CHANGED:
            yield _sides(*self._rung_pair(found.old[0], found.new[0]))
        elif found.kind == MOVED:
            yield f'<div class="alone">{self._rung(found.new[0])}</div>'
        elif found.what == "comment" or not (found.old or found.new):
            yield _rows(found.before, found.after)
        else:
            if found.head:
                yield _rows(*((found.head, "") if found.kind == REMOVED else ("", found.head)))
            yield _sides(self._steps(found.old), self._steps(found.new))

    def _steps(self, steps: Sequence[Step]) -> str:
        shown = "".join(map(self._rung, steps[:MOST_ROWS]))
        hidden = len(steps) - MOST_ROWS
        return shown + (f"<p>… {hidden:,} more</p>" if hidden > 0 else "")

    def _rung_pair(self, old: Step, new: Step) -> tuple[str, str]:
        drawn = pictures(old, new) if self._pictures > 0 else None
        self._pictures -= 2
        before, after = _marked(old.text, new.text)
        first, second = drawn or ("", "")
        return (
            _comment(old) + first + f"<pre>{before}</pre>",
            _comment(new) + second + f"<pre>{after}</pre>",
        )

    def _rung(self, step: Step) -> str:
        drawn = picture(step) if step.what == RUNG and self._pictures > 0 else ""
        self._pictures -= step.what == RUNG
        return f"{_comment(step)}{drawn}<pre>{_shown(step.text)}</pre>"


def _comment(step: Step) -> str:
    return f'<p class="comment">{_shown(step.comment)}</p>' if step.comment else ""


def _sides(old: str, new: str) -> str:
    return f'<div class="sides"><div class="old">{old}</div><div class="new">{new}</div></div>'


def _rows(before: str, after: str) -> str:
    """Return fields side by side, with equal labels in the same row."""
    if not before or not after:
        return _sides(*(f"<pre>{_some(lines)}</pre>" if lines else "" for lines in (before, after)))
    olds, news = before.splitlines(), after.splitlines()
    labels = [[line.partition(" = ")[0] for line in side] for side in (olds, news)]
    rows: list[tuple[str | None, str | None]] = []
    i = k = 0
    for old_end, new_end in [*aligned(labels[0], labels[1]), (len(olds), len(news))]:
        rows += zip_longest(olds[i:old_end], news[k:new_end])
        rows += zip(olds[old_end : old_end + 1], news[new_end : new_end + 1], strict=True)
        i, k = old_end + 1, new_end + 1
    shown = "".join(_row(*row) for row in rows[:MOST_ROWS])
    footer = f"<p>… {len(rows) - MOST_ROWS:,} more lines</p>" if len(rows) > MOST_ROWS else ""
    return f'<div class="fields">{shown}</div>{footer}'


def _some(text: str) -> str:
    lines = text.splitlines()
    hidden = len(lines) - MOST_ROWS
    return "\n".join([*map(_shown, lines[:MOST_ROWS]), *([f"… {hidden:,} more lines"] if hidden > 0 else [])])


def _row(old: str | None, new: str | None) -> str:
    if old is None or new is None:
        before, after = (_shown(text or "") for text in (old, new))
    else:
        before, after = _marked(old, new)
    return _sides(*(f"<pre>{cell}</pre>" if cell else "" for cell in (before, after)))


def _marked(old: str, new: str) -> tuple[str, str]:
    """Return both texts, with the words marked that the other one lacks."""
    if max(len(old), len(new)) > MOST_CHARACTERS:
        return _shown(old), _shown(new)
    before, after = tokens_of(old), tokens_of(new)
    pairs = aligned(before, after)
    return (
        _with_marks(old, before, _slid(before, {i for i, _ in pairs}), "del"),
        _with_marks(new, after, _slid(after, {k for _, k in pairs}), "ins"),
    )


def _slid(tokens: Sequence[str], same: set[int]) -> set[int]:
    """Shift each difference so that it ends with its bracket: `XIC(Guard)`, not `)XIC(Guard`."""
    for index, token in enumerate(tokens):
        if token in ")]" and index not in same:
            end = next((n for n in range(index, len(tokens)) if n in same), len(tokens))
            if end < len(tokens) and tokens[end] == token:
                same = same - {end} | {index}
    return same


def _with_marks(text: str, tokens: Sequence[str], same: set[int], mark: str) -> str:
    parts: list[str] = []
    position = 0
    for number, token in enumerate(tokens):
        begin = text.index(token, position)
        parts.append(_shown(text[position:begin]))
        position = begin + len(token)
        parts.append(_shown(token) if number in same else f"<{mark}>{_shown(token)}</{mark}>")
    return "".join(parts).replace(f"</{mark}><{mark}>", "")
