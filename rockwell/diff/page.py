"""Writes a comparison as one HTML file: both versions side by side, changed rungs drawn, differences marked.

The page loads no files and runs no scripts; its content policy allows only its own style sheet. Every text
from the files is escaped, and characters without a glyph are shown as Python escapes.
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
"""Maximum number of rungs that are drawn; others are shown as text."""

MOST_ROWS = 200
"""Maximum number of lines of a difference on the page."""

MOST_CHARACTERS = 20_000
"""Maximum number of characters of a line on the page."""

SIGNS = {ADDED: "+", REMOVED: "−", CHANGED: "≠", MOVED: "↕", RENAMED: "→"}


def page_of(comparison: Comparison, old: str, new: str) -> str:
    """Return the page of a comparison of two files, given their names."""
    digest = base64.b64encode(sha256(STYLE.encode()).digest()).decode()
    policy = f"default-src 'none'; style-src 'sha256-{digest}'; base-uri 'none'; form-action 'none'"
    title = f"{_shown(new)} against {_shown(old)}"
    return "\n".join(
        (
            '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">',
            f'<meta http-equiv="Content-Security-Policy" content="{policy}">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f"<title>{title}</title>\n<style>{STYLE}</style></head><body>",
            *_Page(comparison).body(f"<span>{_shown(new)}</span> against <span>{_shown(old)}</span>"),
            "</body></html>\n",
        )
    )


def _shown(text: str) -> str:
    """Escape text from a file, and shorten it."""
    if len(text) > MOST_CHARACTERS:
        text = f"{text[:MOST_CHARACTERS]}… {len(text):,} characters"
    return escape(visible(text))


class _Page:
    """Writes the body of the page."""

    def __init__(self, comparison: Comparison) -> None:
        self._comparison = comparison
        self._pictures_left = MOST_PICTURES
        self._groups = list(comparison.by_owner().items())

    def body(self, title: str) -> Iterator[str]:
        """Yield the parts of the page's body."""
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
        """Yield links to the sections, each with the number of its differences of each kind."""
        yield '<nav aria-label="contents"><ol>'
        for number, (owner, differences) in enumerate(self._groups):
            counts = Counter(difference.kind for difference in differences)
            signs = "".join(
                f'<b class="{kind}" title="{kind}">{SIGNS[kind]}{count}</b>' for kind, count in counts.items()
            )
            yield f'<li><a href="#s{number}">{_shown(owner or "Controller")}</a> {signs}</li>'
        yield "</ol></nav>"

    def _difference(self, difference: Difference) -> str:
        kind = difference.kind
        heading = f'<h3><b class="{kind}">{SIGNS[kind]}</b> {_shown(difference.heading)}</h3>'
        return f'<article class="{kind}">{heading}{self._content(difference)}</article>'

    def _content(self, difference: Difference) -> str:
        """Return the texts or rungs of a difference; a changed rung shows both versions side by side."""
        old_steps, new_steps, fields = difference.old_steps, difference.new_steps, difference.fields_text
        if difference.noun == RUNG and difference.kind == CHANGED:
            return _sides(*self._rung_pair(old_steps[0], new_steps[0]))
        if difference.kind == MOVED:
            return f'<div class="alone">{self._rung(new_steps[0])}</div>'
        if difference.noun == "comment" or not (old_steps or new_steps):
            return _rows(difference.old_text, difference.new_text)
        rows = ""
        if fields:
            rows = _rows(fields, "") if difference.kind == REMOVED else _rows("", fields)
        return rows + _sides(self._steps(old_steps), self._steps(new_steps))

    def _steps(self, steps: Sequence[Step]) -> str:
        """Return the first steps of an added or removed item, and the number of the others."""
        shown = "".join(map(self._rung, steps[:MOST_ROWS]))
        hidden = len(steps) - MOST_ROWS
        return shown + (f"<p>… {hidden:,} more</p>" if hidden > 0 else "")

    def _rung_pair(self, old: Step, new: Step) -> tuple[str, str]:
        """Return both versions of a rung as text with marks, and as pictures up to the page's limit."""
        drawn = pictures(old, new) if self._pictures_left > 0 else None
        self._pictures_left -= 2
        old_text, new_text = _marked(old.text, new.text)
        old_picture, new_picture = drawn or ("", "")
        return (
            f"{_comment(old)}{old_picture}<pre>{old_text}</pre>",
            f"{_comment(new)}{new_picture}<pre>{new_text}</pre>",
        )

    def _rung(self, step: Step) -> str:
        """Return a step as text, and a rung also as a picture up to the page's limit."""
        drawn = picture(step) if step.noun == RUNG and self._pictures_left > 0 else ""
        if step.noun == RUNG:
            self._pictures_left -= 1
        return f"{_comment(step)}{drawn}<pre>{_shown(step.text)}</pre>"


def _comment(step: Step) -> str:
    return f'<p class="comment">{_shown(step.comment)}</p>' if step.comment else ""


def _sides(old: str, new: str) -> str:
    return f'<div class="sides"><div class="old">{old}</div><div class="new">{new}</div></div>'


def _rows(old_text: str, new_text: str) -> str:
    """Return the lines of two texts side by side, with equal labels in the same row."""
    if not old_text or not new_text:
        return _sides(*(f"<pre>{_first_lines(text)}</pre>" if text else "" for text in (old_text, new_text)))
    old, new = old_text.splitlines(), new_text.splitlines()
    old_labels, new_labels = ([line.partition(" = ")[0] for line in lines] for lines in (old, new))
    rows: list[tuple[str | None, str | None]] = []
    old_begin = new_begin = 0
    for i, k in aligned(old_labels, new_labels):
        rows += zip_longest(old[old_begin:i], new[new_begin:k])
        rows.append((old[i], new[k]))
        old_begin, new_begin = i + 1, k + 1
    rows += zip_longest(old[old_begin:], new[new_begin:])
    shown = "".join(_row(*row) for row in rows[:MOST_ROWS])
    footer = f"<p>… {len(rows) - MOST_ROWS:,} more lines</p>" if len(rows) > MOST_ROWS else ""
    return f'<div class="fields">{shown}</div>{footer}'


def _first_lines(text: str) -> str:
    """Return the first lines of a text, and the number of remaining lines."""
    lines = text.splitlines()
    shown = [_shown(line) for line in lines[:MOST_ROWS]]
    if len(lines) > MOST_ROWS:
        shown.append(f"… {len(lines) - MOST_ROWS:,} more lines")
    return "\n".join(shown)


def _row(old: str | None, new: str | None) -> str:
    """Return two lines side by side, with marks where they differ; None for a missing line."""
    cells = (_shown(old or ""), _shown(new or "")) if old is None or new is None else _marked(old, new)
    return _sides(*(f"<pre>{cell}</pre>" if cell else "" for cell in cells))


def _marked(old: str, new: str) -> tuple[str, str]:
    """Return both texts, with marks on the words that the other text lacks."""
    if max(len(old), len(new)) > MOST_CHARACTERS:
        return _shown(old), _shown(new)
    old_tokens, new_tokens = tokens_of(old), tokens_of(new)
    pairs = aligned(old_tokens, new_tokens)
    return (
        _with_marks(old, old_tokens, {i for i, _ in pairs}, "del"),
        _with_marks(new, new_tokens, {k for _, k in pairs}, "ins"),
    )


def _with_marks(text: str, tokens: Sequence[str], common: set[int], tag: str) -> str:
    """Return a text; put the tokens that only this text has in elements `tag`.

    Args:
        common: the indexes of the tokens that both texts have.
    """
    _end_with_brackets(tokens, common)
    pieces: list[str] = []
    position = 0
    for index, token in enumerate(tokens):
        begin = text.index(token, position)
        pieces.append(_shown(text[position:begin]))
        position = begin + len(token)
        pieces.append(_shown(token) if index in common else f"<{tag}>{_shown(token)}</{tag}>")
    return "".join(pieces).replace(f"</{tag}><{tag}>", "")


def _end_with_brackets(tokens: Sequence[str], common: set[int]) -> None:
    """Shift marks that begin with a closing bracket, to mark `XIC(Guard)` instead of `)XIC(Guard`.

    In `XIC(A)XIC(Guard)`, the first bracket becomes common, and the last one is marked instead. This is
    possible if the same bracket follows the mark.
    """
    for begin, token in enumerate(tokens):
        if token in ")]" and begin not in common:
            end = next((index for index in range(begin, len(tokens)) if index in common), None)
            if end is not None and tokens[end] == token:
                common.remove(end)
                common.add(begin)
