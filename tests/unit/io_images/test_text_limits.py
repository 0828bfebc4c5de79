"""Texts that others may have made: a step beyond a limit is refused, and what is within costs in proportion.

Cost is what a reader does, counted: the lines that Python executes, and the most memory. Four times the text
takes at most 6.25 times as much of both, where a quadratic reader takes 16 times. All texts have sizes that
the limits allow.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable
from contextlib import suppress
from decimal import Decimal
from pathlib import Path

import pytest
from costs import lines_executed, most_memory
from scanrack.io_images import doors
from scanrack.io_images.doors import json_value
from scanrack.io_images.text_limits import LIMITS, TextKind, TextLimitError, check_text
from scanrack.ladder.files import parse_program, parse_structured
from scanrack.ladder.files.steps import parse_steps
from scanrack.ladder.run.edit import retain
from scanrack.ladder.st import parse_statements
from scanrack.runtime import parse_rack_file

GROWTH = 6.25
SMALL, LARGE = 2_500, 10_000
"""Characters of a text; no limit of a size is below."""

CHECKED = [each for each in LIMITS if each not in (TextKind.PYTHON, TextKind.EXPORT)]
"""The others are limited in size only, see `LIMITS`."""


def toml(text: str) -> object:
    return parse_rack_file(text, Path("rack.toml"))


def rungs(text: str) -> object:
    return parse_program(f"PROGRAM p\n{text}")


def structured(text: str) -> object:
    return parse_structured(text, "p")


def retained(text: str) -> object:
    return retain(parse_program("PROGRAM p\nTAG a : DINT\nROUTINE Main\nNOP();\nEND\n").engine, text)


def scenario(text: str) -> object:
    return json_value(text, TextKind.SCENARIO)


TOO_SHORT = '[[slot]]\nnumber = 1\nmodule = "amci3601"\n'

CASES: dict[str, tuple[Callable[[str], object], Callable[[int], str]]] = {
    "toml: dotted keys": (toml, lambda n: "".join(f"{'a.' * 15}a{i} = 1\n" for i in range(n // 40))),
    "toml: unknown keys": (toml, lambda n: "".join(f"a{i} = 1\n" for i in range(n // 8))),
    "toml: arrays that are too short": (toml, lambda n: TOO_SHORT + "[[slot.machine.slips]]\n" * (n // 20)),
    "toml: tables": (toml, lambda n: "".join(f"[a{i}]\n" for i in range(n // 40))),
    "toml: strings": (toml, lambda n: 'a = ["' + 'a", "' * (n // 5) + '"]'),
    "toml: comments": (toml, lambda n: "# a\n" * (n // 4)),
    "st: comments without an end": (parse_statements, lambda n: "(*" * (n // 2)),
    "st: a string without an end": (parse_statements, lambda n: "S := '" + "$'" * (n // 2)),
    "st: apostrophes": (parse_statements, lambda n: "'" * n),
    "st: parentheses side by side": (parse_statements, lambda n: "A := (1);\n" * (n // 10)),
    "st file: declarations": (structured, lambda n: "".join(f"TAG A{i} : DINT\n" for i in range(n // 10))),
    "st file: members": (structured, lambda n: f"A := {'a.' * 60}a;\n" * (n // 120)),
    "rungs: programs": (rungs, lambda n: "TASK T : CONTINUOUS RUNS " + "a, " * (n // 3)),
    "rungs: branches side by side": (rungs, lambda n: "ROUTINE Main\n" + "[NOP(),NOP()]" * (n // 13)),
    "rungs: initial values": (rungs, lambda n: "TAG A : DINT[2] := [" + "1, " * (n // 3)),
    "steps: words": (parse_steps, lambda n: f"words {'1 ' * (n // 2)}"),
    "steps: lines": (parse_steps, lambda n: "zero for 1 ms\n" * (n // 14)),
    "retained: brackets side by side": (retained, lambda n: f"[{'[],' * (n // 3)}1]"),
    "retained: keys": (retained, lambda n: "{" + "".join(f'"a{i}":1,' for i in range(n // 8)) + '"a":1}'),
}
"""What reads a text, and a text of about so many characters."""

OVER: dict[str, tuple[Callable[[str], object], str]] = {
    "toml: a dotted key": (toml, "a." * 16 + "a = 1"),
    "toml: a dotted header": (toml, f"[{'a.' * 16}a]"),
    "toml: a dotted key of quoted parts": (toml, '"a".' * 16 + "a = 1"),
    "toml: brackets": (toml, "a = " + "[" * 33),
    "toml: a string without an end": (toml, 'a = "' + '\\"' * 2_048),
    "toml: a long string without an end": (toml, 'a = """' + '\\"' * 2_047),
    "toml: a number": (toml, "a = " + "1" * 4_097),
    "st file: a string without an end": (structured, "S := '" + "$'" * 2_048),
    "st file: parentheses": (structured, "A := " + "(" * 1_001),
    "st file: members": (structured, "A := " + "a." * 64 + "a"),
    "rungs: a string without an end": (rungs, "ROUTINE Main\nXIC('" + "$'" * 2_048),
    "rungs: blanks": (rungs, f"TAG A : DINT{' ' * 4_097}x"),
    "rungs: blanks in a type": (rungs, f"TYPE A ({' ' * 4_097}x"),
    "rungs: brackets": (rungs, "ROUTINE Main\n" + "[" * 1_001),
    "rungs: an initial value": (rungs, "TAG A : DINT[2] := " + "[" * 1_001),
    "rungs: members": (rungs, "ALIAS A : " + "a." * 64 + "a"),
    "steps: blanks": (parse_steps, f"zero{' ' * 4_097}x"),
    "steps: a number": (parse_steps, f"target {'1' * 4_097}"),
    "retained: brackets": (retained, "[" * 65),
    "retained: a string": (retained, '"' + '\\"' * 65_536),
    "retained: a number": (retained, "1" * 4_301),
    "scenario: brackets": (scenario, "[" * 65),
    "scenario: a number": (scenario, "1" * 4_097),
}
"""What reads a text, and a text that is one step beyond a limit."""


@pytest.mark.parametrize("name", CASES)
def test_four_times_the_text_takes_at_most_six_times_as_much(name: str) -> None:
    reader, make = CASES[name]

    def cost(text: str) -> tuple[int, int]:
        def read() -> None:
            with suppress(ValueError):
                reader(text)

        read()  # what is made once, such as a grammar, is no cost of the text
        return lines_executed(read), most_memory(read)

    (lines_1, memory_1), (lines_4, memory_4) = cost(make(SMALL)), cost(make(LARGE))
    assert lines_4 <= GROWTH * lines_1, (lines_1, lines_4)
    assert memory_4 <= GROWTH * memory_1 + 20_000, (memory_1, memory_4)


@pytest.mark.parametrize("name", OVER)
def test_a_step_beyond_a_limit_is_refused_before_a_parser_reads(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def parses(*_: object, **__: object) -> None:
        raise AssertionError("a parser was called")

    monkeypatch.setattr(tomllib, "loads", parses)
    monkeypatch.setattr(json, "loads", parses)
    reader, text = OVER[name]
    with pytest.raises(ValueError, match=r"of more than|nested deeper than") as refused:
        reader(text)
    assert any(isinstance(each, TextLimitError) for each in (refused.value, refused.value.__context__))


@pytest.mark.parametrize("kind", CHECKED)
def test_each_limit_holds(kind: TextKind) -> None:
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


PIECES: dict[str, Callable[[int], str]] = {
    "a string": lambda n: f'"{"a" * (n - 2)}"\n',
    "escapes": lambda n: f'"{chr(92) * (n // 2 * 2 - 2)}"\n',
    "a string of dollars": lambda n: f"'{'$' * (n // 2 * 2 - 2)}'\n",
    "a long string": lambda n: f'''"""{'a"' * (n // 2 - 3)}"""\n''',
    "a comment": lambda n: f"#{'a' * n}\n",
    "a comment in brackets": lambda n: f"(*{'a' * n}*)\n",
    "a name": lambda n: f"{'a' * n}\n",
    "blanks": lambda n: f"a{' ' * n}\n",
}
"""Parts of a text, each about as long as may be."""


@pytest.mark.parametrize("piece", PIECES)
@pytest.mark.parametrize("kind", CHECKED)
def test_the_guard_takes_no_more_memory_for_a_longer_text(kind: TextKind, piece: str) -> None:
    for text in (PIECES[piece](500), PIECES[piece](LIMITS[kind].token), PIECES[piece](4_000) * 8):
        assert most_memory(lambda text=text: check_text(text, kind)) < 8_000  # type: ignore[misc]


@pytest.mark.parametrize("kind", [TextKind.PLAN, TextKind.RETAINED, TextKind.STATE])
def test_a_number_has_as_many_digits_as_python_converts(kind: TextKind) -> None:
    """These kinds have longer names and texts than that."""
    check_text(f"\n{'1' * 4300}\n{'a' * 4301}\n", kind)
    for sign in ("", "-"):
        with pytest.raises(TextLimitError, match="a number of more than 4,300 digits") as refused:
            check_text(f"\n{sign}{'1' * 4301}\n", kind)
        assert refused.value.line == 2


def test_an_exponent_that_no_decimal_has_is_no_number() -> None:
    """`Decimal` refuses it as it refuses other texts."""
    assert doors._fraction("1.5") == Decimal("1.5")
    assert doors._fraction("1e").is_nan()
