"""`scanrack rules amci3601`: the rule table, with the tests that prove each row."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from enum import StrEnum
from textwrap import wrap
from typing import Annotated

import typer

from ...io_images.amci3601 import RULES, Firmware, StatusLsw, StatusMsw, bit_names
from ...io_images.amci3601.rules import Rule
from ...io_images.amci3601.rules.proofs import proofs
from .rules_page import chapter_of, firmware_words, page
from .status import BAD_INPUT, DONE, NO
from .terminal import say

WIDTH = 80
INDENT = " " * 9

BITS: Mapping[str, int] = {str(bit.name): bit.value for bit in StatusMsw} | {
    str(bit.name): bit.value << 16 for bit in StatusLsw
}
"""Every status bit's mask in `Rule.sets` and `Rule.clears`, by name."""


class Table(StrEnum):
    """Whose rules."""

    AMCI3601 = "amci3601"


def with_ids(rules: Iterable[Rule], wanted: Sequence[str]) -> list[Rule]:
    """Return the rules with one of these ids or prefixes ("CMD-03", "CMD"); all of them if none is given.

    Raises:
        ValueError: there is no such id or prefix; the closest ones.
    """
    names = {name.upper() for name in wanted}
    prefixes = list(dict.fromkeys(prefix_of(rule_id) for rule_id in RULES))
    for name in sorted(names - set(prefixes) - set(RULES)):
        among = [rule_id for rule_id in RULES if prefix_of(rule_id) == prefix_of(name)]
        allowed = f"{among[0]} to {among[-1]}" if among else ", ".join(prefixes)
        raise ValueError(_unknown("rule", name, among or prefixes, allowed))
    return [rule for rule in rules if not names or names & {rule.id, prefix_of(rule.id)}]


def with_bit(rules: Iterable[Rule], name: str) -> list[Rule]:
    """Return the rules that set or clear the status bit of this name.

    Raises:
        ValueError: there is no such bit; all there are, and the closest one.
    """
    if name.upper() not in BITS:
        raise ValueError(_unknown("status bit", name, list(BITS), ", ".join(BITS)))
    mask = BITS[name.upper()]
    return [rule for rule in rules if (rule.sets | rule.clears) & mask]


def of_firmware(rules: Iterable[Rule], version: str) -> list[Rule]:
    """Return the rules that a module with this firmware knows.

    Raises:
        ValueError: there is no such version.
    """
    firmware = Firmware.parse(version)
    return [rule for rule in rules if rule.applies_to(firmware)]


def untested(rules: Iterable[Rule]) -> list[Rule]:
    """Return the rules that an image could show to hold, and that no test proves."""
    return [rule for rule in rules if rule.testable and not proofs(rule.id)]


def prefix_of(rule_id: str) -> str:
    """Return the letters of a rule's id.

    >>> prefix_of("CMD-03"), prefix_of("STS-M07")
    ('CMD', 'STS')
    """
    return rule_id.split("-")[0]


def _unknown(what: str, name: str, known: Sequence[str], allowed: str) -> str:
    """Return the refusal of a name, with what was probably meant and what is allowed."""
    close = difflib.get_close_matches(name.upper(), known, n=1, cutoff=0.5)
    meant = f" (did you mean {close[0]}?)" if close else ""
    return f"unknown {what} {name!r}{meant}: allowed are {allowed}"


# -- as text ----------------------------------------------------------------------------------------


def listing(rules: Sequence[Rule]) -> str:
    """Return the rules as text of 80 columns, under their chapters, with a closing count.

    Names of tests are not broken, so a line with one can be longer.
    """
    lines: list[str] = []
    chapter = ""
    for rule in rules:
        if chapter_of(rule) != chapter:
            chapter = chapter_of(rule)
            lines += [chapter, "=" * len(chapter), ""]
        lines += [*entry(rule), ""]
    return "\n".join([*lines, count(rules)])


def entry(rule: Rule) -> Iterator[str]:
    """Yield the lines of one rule."""
    yield f"{rule.id:<{len(INDENT)}}{rule.section}"
    yield from _paragraph(rule.text)
    for title, words in (
        ("sets", ", ".join(bit_names(rule.sets))),
        ("clears", ", ".join(bit_names(rule.clears))),
        ("with", ", ".join(rule.together_with)),
        ("firmware", firmware_words(rule)),
        ("reading", ", ".join(rule.reading)),
    ):
        if words:
            yield from _paragraph(f"{title}: {words}")
    yield from _proof_lines(rule)


def _proof_lines(rule: Rule) -> Iterator[str]:
    """Yield the tests, each file's under its name, and why there may be none."""
    if not rule.testable:
        yield from _paragraph(f"in no image: {rule.untestable_because}")
    elif not proofs(rule.id):
        yield from _paragraph("tests: none")
    file = ""
    for test in proofs(rule.id):
        before, (file, name) = file, test.split("::", 1)
        if file != before:
            yield from _paragraph(f"tests: {file}")
        yield f"{INDENT}  {name}"


def _paragraph(text: str) -> list[str]:
    return wrap(
        text,
        WIDTH,
        initial_indent=INDENT,
        subsequent_indent=INDENT,
        break_long_words=False,
        break_on_hyphens=False,
    )


def count(rules: Sequence[Rule]) -> str:
    """Return how many rules there are, and how they are proved."""
    proved = sum(1 for rule in rules if proofs(rule.id))
    bare = sum(1 for rule in rules if not (rule.testable or proofs(rule.id)))
    missing = len(untested(rules))
    rows = f"{len(rules)} rule{'' if len(rules) == 1 else 's'}"
    return f"{rows}: {proved} proved by tests, {bare} not testable, {missing} without a test"


# -- the command ------------------------------------------------------------------------------------


def _rules_command(
    table: Annotated[Table, typer.Argument(help="Whose rules.", show_default=False)],
    ids: Annotated[
        list[str] | None,
        typer.Option("--id", metavar="ID", help="Only this rule, or all with this prefix; may be repeated."),
    ] = None,
    bit: Annotated[
        str | None,
        typer.Option("--bit", metavar="NAME", help="Only rules that set or clear this status bit."),
    ] = None,
    firmware: Annotated[
        str | None, typer.Option("--firmware", metavar="VERSION", help="Only rules that this version knows.")
    ] = None,
    without_test: Annotated[
        bool, typer.Option("--untested", help="Only rules that no test proves though one could.")
    ] = False,
    markdown: Annotated[bool, typer.Option("--markdown", help="As the page docs/rules-amci3601.md.")] = False,
) -> None:
    """Print the rules of a module's manual: section, words, status bits, and the tests that prove each.

    Exit status: 0 printed, 1 --untested has found any, 2 an option can't be used.
    """
    try:
        rules = with_ids(RULES.values(), ids or ())
        rules = rules if bit is None else with_bit(rules, bit)
        rules = rules if firmware is None else of_firmware(rules, firmware)
    except ValueError as error:
        say(f"scanrack: {error}", err=True)
        raise typer.Exit(BAD_INPUT) from error
    rules = untested(rules) if without_test else rules
    say(page(rules, proofs) if markdown else listing(rules), nl=not markdown)
    raise typer.Exit(NO if without_test and rules else DONE)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("rules", no_args_is_help=True)(_rules_command)
