"""Texts that others may have made: four times the text takes at most 6.25 times the time and memory.

That is 2.5 times for twice the text, as the limits promise; a quadratic reader takes 16 times. Time is the
least processor time of some tries, of more where a busy machine disturbs them.
"""

from __future__ import annotations

import json
import time
import tracemalloc
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest
from scanrack.io_images.text_limits import LIMITS, TextKind, TextLimitError, check_text
from scanrack.ladder import Program
from scanrack.ladder.files import parse_program, parse_structured
from scanrack.ladder.files.steps import parse_steps
from scanrack.ladder.run.edit import retain
from scanrack.ladder.st import parse_statements
from scanrack.runtime import parse_rack_file

GROWTH = 6.25
ROUNDS = 10


def toml(text: str) -> object:
    return parse_rack_file(text, Path("rack.toml"))


def rungs(text: str) -> object:
    return parse_program(f"PROGRAM p\n{text}")


def structured(text: str) -> object:
    return parse_structured(text, "p")


def retained(text: str) -> object:
    return retain(Program("p").engine, text)


def scenario(text: str) -> object:
    check_text(text, TextKind.SCENARIO)
    return json.loads(text)


TOO_SHORT = '[[slot]]\nnumber = 1\nmodule = "amci3601"\n'

CASES: dict[str, tuple[Callable[[str], object], Callable[[int], str]]] = {
    "toml: a dotted key": (toml, lambda n: "a." * n + "a = 1"),
    "toml: a dotted header": (toml, lambda n: f"[{'a.' * n}a]"),
    "toml: a dotted key of quoted parts": (toml, lambda n: '"a".' * n + "a = 1"),
    "toml: dotted keys": (toml, lambda n: "".join(f"{'a.' * 15}a{i} = 1\n" for i in range(n // 40))),
    "toml: unknown keys": (toml, lambda n: "".join(f"a{i} = 1\n" for i in range(n // 8))),
    "toml: arrays that are too short": (toml, lambda n: TOO_SHORT + "[[slot.machine.slips]]\n" * (n // 20)),
    "toml: brackets": (toml, lambda n: "a = " + "[" * n),
    "toml: tables": (toml, lambda n: "".join(f"[a{i}]\n" for i in range(n // 40))),
    "toml: a string without an end": (toml, lambda n: 'a = "' + '\\"' * n),
    "toml: a number": (toml, lambda n: "a = " + "1" * n),
    "st: escapes in a string without an end": (parse_statements, lambda n: "S := '" + "$'" * n),
    "st file: escapes in a string without an end": (structured, lambda n: "S := '" + "$'" * n),
    "st: comments without an end": (parse_statements, lambda n: "(*" * n),
    "st: apostrophes": (parse_statements, lambda n: "'" * n),
    "st file: declarations": (structured, lambda n: "".join(f"TAG A{i} : DINT\n" for i in range(n // 10))),
    "st file: parentheses": (structured, lambda n: "A := " + "(" * n),
    "st file: members": (structured, lambda n: "A := " + "a." * n),
    "rungs: escapes in a string without an end": (rungs, lambda n: "ROUTINE Main\nXIC('" + "$'" * n),
    "rungs: blanks": (rungs, lambda n: f"TAG A : DINT{' ' * n}x"),
    "rungs: blanks in a type": (rungs, lambda n: f"TYPE A ({' ' * n}x"),
    "rungs: brackets": (rungs, lambda n: "ROUTINE Main\n" + "[" * n),
    "rungs: an initial value": (rungs, lambda n: "TAG A : DINT[2] := " + "[" * n),
    "rungs: members": (rungs, lambda n: "ALIAS A : " + "a." * n),
    "rungs: programs": (rungs, lambda n: "TASK T : CONTINUOUS RUNS " + "a, " * n),
    "steps: blanks": (parse_steps, lambda n: f"zero{' ' * n}x"),
    "steps: words": (parse_steps, lambda n: f"words {'1 ' * n}"),
    "steps: a number": (parse_steps, lambda n: f"target {'1' * n}"),
    "retained: brackets": (retained, lambda n: "[" * n),
    "retained: a string": (retained, lambda n: '"' + '\\"' * n),
    "retained: a number": (retained, lambda n: "1" * n),
    "scenario: brackets": (scenario, lambda n: "[" * n),
    "scenario: a number": (scenario, lambda n: "1" * n),
}
"""What reads a text, and a text of about so many characters."""


def cost(reader: Callable[[str], object], text: str) -> tuple[float, int]:
    """Return the processor time, s, and the most memory, bytes, of reading a text."""

    def read() -> None:
        with suppress(ValueError):
            reader(text)

    read()
    spent = []
    for _ in range(3):
        begun = time.process_time()
        read()
        spent.append(time.process_time() - begun)
    tracemalloc.start()
    read()
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return min(spent), most


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_four_times_the_text_takes_at_most_six_times_as_much(name: str) -> None:
    reader, text = CASES[name]
    small, large = text(5_000), text(20_000)
    (time_1, memory_1), (time_4, memory_4) = cost(reader, small), cost(reader, large)
    for _ in range(ROUNDS):
        if time_4 <= GROWTH * time_1 + 0.002:
            break
        time_4 = min(time_4, cost(reader, large)[0])
    else:
        raise AssertionError(f"{time_1} s for the small text, {time_4} s for the large one")
    assert memory_4 <= GROWTH * memory_1 + 20_000, (memory_1, memory_4)


@pytest.mark.parametrize("kind", LIMITS)
def test_each_limit_holds(kind: TextKind) -> None:
    if kind in (TextKind.PYTHON, TextKind.EXPORT):
        return
    limits = LIMITS[kind]
    just = {
        "[" * limits.nesting: "[",
        "a." * (limits.parts - 1) + "a": ".a",
        "a" * limits.token: "a",
        f"x{' ' * limits.token}": " ",
    }
    for text, more in just.items():
        check_text(f"\n{text}\n", kind)
        with pytest.raises(TextLimitError) as refused:
            check_text(f"\n{text}{more}\n", kind)
        assert refused.value.line == 2
    if limits.size < 1 << 24:
        with pytest.raises(TextLimitError, match=f"of more than {limits.size:,} characters"):
            check_text("\n" * (limits.size + 1), kind)


@pytest.mark.parametrize("kind", [TextKind.PLAN, TextKind.RETAINED, TextKind.STATE])
def test_a_number_has_as_many_digits_as_python_converts(kind: TextKind) -> None:
    """These kinds have longer names and texts than that."""
    check_text(f"\n{'1' * 4300}\n{'a' * 4301}\n", kind)
    for sign in ("", "-"):
        with pytest.raises(TextLimitError, match="a number of more than 4,300 digits") as refused:
            check_text(f"\n{sign}{'1' * 4301}\n", kind)
        assert refused.value.line == 2
