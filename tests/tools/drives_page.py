"""The tables of the networked drives: docs/drive-tables.md."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

from scanrack.io_images.drives.models import MODELS, Model
from scanrack.io_images.drives.rules import ROWS, DriveRule
from scanrack.io_images.module_words import BitPlace

PAGE = Path(__file__).parents[2] / "docs" / "drive-tables.md"

INTRO = """\
# Networked drives: tables

Words, bits and rules of [AMCI's networked drives](drives.md). `python -m tests.tools.generate drives` makes
this page from the rows of `io_images/drives/`; don't edit it. Pages are those of the manuals: "SMD" is the
SMD23E2's, "17" the SMD17E2's, "SD" the SD17060E's, "SD2" the SD17060E2's, "K" the SD17060E-K's, "3401" the
3401's; "EDS" is the vendor's EDS file of the SMD23E2. R-numbers are in
[How the manual is read](readings.md#the-networked-drives).
"""


def page() -> str:
    """Return docs/drive-tables.md."""
    return "\n".join([INTRO, *_models(), "", *_bits(), "", *_rules()]) + "\n"


def _models() -> Iterator[str]:
    yield "## Models"
    yield ""
    yield "| model | axes | speed to | rates to | current, 0.1 A | numbers | enable bit | flash |"
    yield "|---|---|---|---|---|---|---|---|"
    for model in MODELS.values():
        limits = model.limits
        cells = (
            f"`{model.name}`",
            str(model.axes),
            f"{limits.speed:,}",
            f"{limits.rate:,}",
            _current(model),
            "configured" if model.number_format is None else f"{model.number_format.value}, high word first",
            "yes" if model.enable_bit else "no",
            "yes" if model.flash else "no",
        )
        yield f"| {' | '.join(cells)} |"


def _current(model: Model) -> str:
    if not model.modifiers:
        return ""
    low, high = model.limits.current
    return f"{low} to {high}" + (", even" if model.limits.current_step == 2 else "")


def _bits() -> Iterator[str]:
    smd, anf2 = MODELS["smd23e2"].words.groups, MODELS["anf2"].words.groups
    for group, title in (
        ("status", "Status bits"),
        ("command", "Command bits"),
        ("modifier", "Modifiers: levels in command word 1"),
    ):
        yield f"## {title}"
        yield ""
        yield "| bit | SMD family, ANG1 | ANF2 |"
        yield "|---|---|---|"
        for name in dict.fromkeys([*smd[group], *anf2[group]]):
            yield f"| `{name}` | {_place(smd[group], name)} | {_place(anf2[group], name)} |"
        yield ""


def _place(bits: Mapping[str, BitPlace], name: str) -> str:
    return f"word {bits[name].word}, bit {bits[name].bit}" if name in bits else ""


def _rules() -> Iterator[str]:
    yield "## Rules"
    yield ""
    yield "A rule that fires is named in the recording and in the summary of a run."
    yield ""
    yield "| rule | source | says | sets | |"
    yield "|---|---|---|---|---|"
    yield from map(_rule, ROWS)


def _rule(row: DriveRule) -> str:
    bits = ", ".join(f"`{bit.name}`" for bit in row.sets)
    return f"| {row.id} | {row.section} | {row.text} | {bits} | {', '.join(row.reading)} |"
