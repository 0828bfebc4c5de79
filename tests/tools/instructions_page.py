"""The tables of instructions in docs/instructions.md, from the rows in `ladder/instructions`."""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from scanrack.ladder.instructions import FAMILIES, SPECS
from scanrack.ladder.model.spec import Spec
from scanrack.rockwell.l5x.mnemonics import MNEMONICS

PAGE = Path(__file__).parents[2] / "docs/instructions.md"
REMEDY = "python -m tests.tools.generate instructions"
TABLE = re.compile(r"(^\| family \| instructions \|\n\|---\|---\|\n)((?:\|.*\n)*)", re.MULTILINE)


def lines(specs: Sequence[Spec]) -> Iterator[str]:
    """Return the lines of the table: each family, the newer names, what is missing."""
    by_name = {spec.name: spec for spec in specs}
    for family in FAMILIES:
        here = [by_name.pop(name) for name in vars(family) if name in by_name]
        for where, chosen in (
            ("", [spec for spec in here if spec.in_rungs]),
            (", structured text", [spec for spec in here if not spec.in_rungs]),
        ):
            if chosen:
                name = family.__name__.rpartition(".")[2]
                yield f"| {name}{where} | {' '.join(spec.name for spec in chosen)} |"
    if by_name:
        yield f"| no family | {' '.join(by_name)} |"
    yield f"| newer names | {' '.join(f'{spec.other} ({spec.name})' for spec in specs if spec.other)} |"
    known = {name for spec in specs for name in (spec.name, spec.other)}
    yield f"| missing | {' '.join(sorted(MNEMONICS - known))} |"


def missing(page: str, specs: Sequence[Spec] = SPECS) -> list[str]:
    """Return the names in which a page differs from the instruction set, each with the family."""
    found = TABLE.search(page)
    assert found is not None, "no table of instructions"
    ours, theirs = names(list(lines(specs))), names(found[2].splitlines())
    return [f"missing: {each}" for each in ours if each not in theirs] + [
        f"in no file: {each}" for each in theirs if each not in ours
    ]


def names(rows: Sequence[str]) -> list[str]:
    """Return each name of a table with its family."""
    cells = (row.strip("| ").split(" | ") for row in rows)
    return [f"{name} of {family}" for family, text in cells for name in re.findall(r"\w+", text)]


def written(page: str) -> str:
    """Return the page with the instruction set as it is."""
    text = "".join(f"{line}\n" for line in lines(SPECS))
    return TABLE.sub(lambda found: found[1] + text, page)
