"""The table of docs/replacing.md: what means something else on a networked drive."""

from __future__ import annotations

from pathlib import Path

from scanrack.io_images.drives.differences import CONFIGURATION, DIFFERENCES, Difference
from scanrack.io_images.drives.models import Layout

PAGE = Path(__file__).parents[2] / "docs" / "replacing.md"
BEGIN = "## The differences\n"
HEAD = """
| | word and bits | on a 3601 | on the drive | write instead | source |
|---|---|---|---|---|---|
"""
MODELS = {Layout.SMD: "SMD, SD, ANG1", Layout.ANF2: "ANF2"}


def page() -> str:
    """Return the page with its table."""
    text = PAGE.read_text(encoding="utf-8")
    there, here, write, source = CONFIGURATION
    configuration = f"| | configuration | {there} | {here} | {write} | {source} |\n"
    return text[: text.index(BEGIN)] + BEGIN + HEAD + configuration + "".join(map(_row, DIFFERENCES))


def _row(row: Difference) -> str:
    bits = ", ".join(str(bit) for bit in range(16) if row.bits >> bit & 1)
    image, word = row.place
    side = "output" if image == "O" else "input"
    models = "" if len(row.layouts) > 1 else f"{MODELS[row.layouts[0]]}: "
    return (
        f"| {row.id} | {side} word {word}, bits {bits}: {row.names(0xFFFF)} | {row.on_3601} "
        f"| {models}{row.on_drive} | {row.write} | {row.source} |\n"
    )
