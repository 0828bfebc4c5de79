"""Static HTML pictures for notebooks, without scripts or external files, in the page's colors."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

_CARD = "font:13px system-ui;border:1px solid #8884;border-radius:8px;padding:8px 12px;display:inline-block"
_CHIP = "font:11px monospace;padding:1px 6px;margin:1px;border-radius:5px;display:inline-block"
_ON, _OFF = "background:#2a8a4a33;font-weight:700", "opacity:.5"
_CELL = "padding:1px 8px;text-align:{}"


def card(title: str, *parts: str) -> str:
    """Return a frame with a plain-text title and HTML parts."""
    return f'<div style="{_CARD}"><b>{escape(title)}</b>{"".join(parts)}</div>'


def line(text: str) -> str:
    """Return a line of text."""
    return f"<div>{escape(text)}</div>"


def chips(bits: Iterable[tuple[str, bool]]) -> str:
    """Return the names of bits; bits that are on are emphasized."""
    chips_html = (f'<span style="{_CHIP};{_ON if on else _OFF}">{escape(name)}</span>' for name, on in bits)
    return f"<div>{''.join(chips_html)}</div>"


def rows(table: Iterable[Sequence[str]]) -> str:
    """Return a table of texts with the first column left-aligned and the others right-aligned."""
    html = []
    for row in table:
        cells = (
            f'<td style="{_CELL.format("right" if column else "left")}">{escape(cell)}</td>'
            for column, cell in enumerate(row)
        )
        html.append(f"<tr>{''.join(cells)}</tr>")
    return f"<table>{''.join(html)}</table>"


def curve(title: str, values: Sequence[int], width: int = 640, height: int = 70) -> str:
    """Return a line chart of numbers; `width` and `height` are in pixels."""
    lowest, span = min(values), max(max(values) - min(values), 1)
    x_step, y_step = width / max(len(values) - 1, 1), (height - 12) / span
    points = " ".join(
        f"{index * x_step:.1f},{height - 6 - (value - lowest) * y_step:.1f}"
        for index, value in enumerate(values)
    )
    return (
        f'<svg viewBox="0 0 {width} {height}" width="{width}" height="{height}" style="display:block">'
        f"<title>{escape(title)}</title>"
        f'<polyline points="{points}" fill="none" stroke="currentColor" stroke-opacity=".75"/></svg>'
    )
