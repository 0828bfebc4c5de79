"""Compare the relation of a program with the interpreter, value by value, until so many are equal.

    python tests/tools/relation_values.py 2000000          until two million values are compared
    python tests/tools/relation_values.py 500000 9000      the same from another seed on

The programs are those of `relation_programs`, `relation_rows`, and `relation_corpus`, and those of the tests
of both back ends (`ladder_programs`, `structured_programs`). The status is 1 if a value differs or an
instruction was not met.
"""

from __future__ import annotations

import itertools
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

import hypothesis
import ladder_programs
import structured_programs
from relation import Relation
from relation_corpus import machine_text
from relation_programs import PROVED_WRONGLY, drawn
from relation_rows import BLOCKS, ROWS, SLC_ROWS, drawn_rows
from scanrack.ladder.files import parse_program

SCANS = 8

WRONGLY_EVERY = 150
"""Programs from one that was proved wrongly to the next."""

AT_ONCE = 40
"""Programs of a strategy that are drawn at once."""


def program_of(seed: int) -> Any:
    """Return the program of a seed: one of two generators, now and then one that was proved wrongly."""
    rounds, turn = divmod(seed, WRONGLY_EVERY)
    if turn < len(PROVED_WRONGLY):
        return parse_program(PROVED_WRONGLY[turn])
    seed -= len(PROVED_WRONGLY) * (rounds + 1)
    return drawn_rows(seed // 2) if seed % 2 else parse_program(drawn(seed // 2))


def strategies(seed: int) -> list[str]:
    """Return programs of rungs and of structured text that tests of both back ends have."""
    found: list[str] = []

    @hypothesis.seed(seed)
    @hypothesis.settings(
        max_examples=AT_ONCE,
        phases=[hypothesis.Phase.generate],
        database=None,
        deadline=None,
        suppress_health_check=list(hypothesis.HealthCheck),
    )
    @hypothesis.given(ladder_programs.programs(), structured_programs.structured())
    def keep(rungs: str, text: str) -> None:
        found.extend((rungs, text))

    keep()
    return found


def programs(first: int) -> Iterator[Any]:
    """Yield programs without end, from a seed on."""
    for seed in itertools.count(first):
        yield program_of(seed)
        if seed % 5 == 4:
            yield parse_program(machine_text(seed))
        if seed % 200 == 199:
            yield from map(parse_program, strategies(seed))


def compare(values: int, first: int = 0) -> int:
    """Compare values from a seed on; return the status."""
    count: Counter[str] = Counter()
    met: set[str] = set()
    for number, program in enumerate(programs(first)):
        relation = Relation(program)
        found = relation.differences(Random(first + number), SCANS, count)
        count["programs"] += 1
        machine = relation.machine
        met |= {step.name for step in machine.lowered.all_steps if step.site in machine.passages}
        if found:
            print(f"program {number} from seed {first} on: {found[0]}")
            return 1
        if count["programs"] % 100 == 0:
            print(", ".join(f"{number:,} {name}" for name, number in count.items()), flush=True)
        if count["values"] >= values:
            break
    missed = sorted({*ROWS, *BLOCKS, *SLC_ROWS} - met)
    print(f"{count['values']:,} values of {count['programs']:,} programs are equal; {len(met)} instructions")
    print(f"not met: {', '.join(missed) or 'none'}")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(compare(*map(int, sys.argv[1:])))
