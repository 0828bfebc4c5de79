"""`scanrack rules amci3601`, `scanrack rules smd23e2`: list the rules in the manuals."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import partial
from textwrap import wrap
from typing import Annotated

import typer
from scanrack.io_images.amci3601 import RULES, Firmware, StatusLsw, StatusMsw
from scanrack.io_images.amci3601.rules import Rule
from scanrack.io_images.drives.bits import StatusBit
from scanrack.io_images.drives.models import MODELS, Model
from scanrack.io_images.drives.rules import DriveRule, rules_of
from scanrack.terminal.as_json import JsonOption, say_json
from scanrack.terminal.complaints import reported_mistakes
from scanrack.terminal.terminal import say

WIDTH = 80
INDENT = " " * 9

CHAPTERS = {
    "Module Overview": "Module Overview",
    "chapter 1": "Chapter 1: Installing the 3601 module",
    "chapter 2": "Chapter 2: Calculating move profiles",
    "chapter 3": "Chapter 3: Configuration mode",
    "chapter 4": "Chapter 4: Command mode operations",
    "chapter 5": "Chapter 5: Command mode data",
    "chapter 6": "Chapter 6: Status and error bits",
    "Manual Revision History": "Manual revision history",
}
"""Chapter titles, by the first words of the sections in the table."""

BITS: Mapping[str, int] = {str(bit.name): bit.value for bit in StatusMsw} | {
    str(bit.name): bit.value << 16 for bit in StatusLsw
}
"""The mask of every status bit in `Rule.sets` and `Rule.clears`, by name."""


TOPICS = {
    "CFG": "Configuration mode",
    "CMD": "Commands",
    "JOG": "Jogs",
    "INP": "Inputs",
    "POS": "Position",
    "DRV": "Driver",
}
"""Topics of a drive's rules, by the letters of the rule ids."""


@dataclass(frozen=True, slots=True)
class RuleTable:
    """The rules of a module, by id, and the masks of its status bits, by name."""

    rules: Mapping[str, Rule]
    bits: Mapping[str, int]

    def names(self, mask: int) -> tuple[str, ...]:
        """Return the names of the bits in a mask."""
        return tuple(name for name, bit in self.bits.items() if bit & mask)


def _drive_table(model: Model) -> RuleTable:
    bits = {str(bit.name): bit.value for bit in StatusBit if model.moved_status.get(bit, bit.value)}
    return RuleTable({row.id: _rule(row) for row in rules_of(model)}, bits)


def _rule(row: DriveRule) -> Rule:
    return Rule(row.id, row.section, row.text, sets=int(row.sets), reading=row.reading)


AMCI3601 = RuleTable(RULES, BITS)

TABLES: Mapping[str, Callable[[], RuleTable]] = {
    "amci3601": lambda: AMCI3601,
    **{name: partial(_drive_table, model) for name, model in MODELS.items()},
}
"""Functions that return a module's rule table, by module."""

Table = StrEnum("Table", {name.upper(): name for name in TABLES})  # type: ignore[misc]  # from the table


def with_ids(rules: Iterable[Rule], chosen: Sequence[str], table: RuleTable) -> list[Rule]:
    """Return the rules with the given ids or prefixes ("CMD-03", "CMD"), or all rules if none is given.

    Raises:
        ValueError: an unknown id or prefix; the message suggests the closest one.
    """
    names = {name.upper() for name in chosen}
    prefixes = list(dict.fromkeys(map(prefix_of, table.rules)))
    for name in sorted(names - set(prefixes) - set(table.rules)):
        ids = [rule_id for rule_id in table.rules if prefix_of(rule_id) == prefix_of(name)]
        allowed = f"{ids[0]} to {ids[-1]}" if ids else ", ".join(prefixes)
        raise ValueError(_unknown("rule", name, ids or prefixes, allowed))
    return [rule for rule in rules if not names or names & {rule.id, prefix_of(rule.id)}]


def with_bit(rules: Iterable[Rule], name: str, table: RuleTable = AMCI3601) -> list[Rule]:
    """Return the rules that set or clear a status bit.

    Raises:
        ValueError: an unknown bit; the message lists all bits and suggests the closest one.
    """
    if name.upper() not in table.bits:
        raise ValueError(_unknown("status bit", name, list(table.bits), ", ".join(table.bits)))
    mask = table.bits[name.upper()]
    return [rule for rule in rules if (rule.sets | rule.clears) & mask]


def of_firmware(rules: Iterable[Rule], version: str) -> list[Rule]:
    """Return the rules that apply to a firmware version; raise ValueError for an unknown version."""
    firmware = Firmware.parse(version)
    return [rule for rule in rules if rule.applies_to(firmware)]


def chapter_of(rule: Rule) -> str:
    """Return the chapter title of a rule, or the topic of a drive's rule."""
    return CHAPTERS.get(rule.section.split(",")[0]) or TOPICS[prefix_of(rule.id)]


def firmware_words(rule: Rule) -> str:
    """Return a rule's firmware versions, such as "from 3.1" or "before 3.1"; "" means all versions."""
    since = "" if rule.firmware_from is None else f"from {rule.firmware_from}"
    until = "" if rule.firmware_until is None else f"before {rule.firmware_until}"
    return ", ".join(filter(None, (since, until)))


def prefix_of(rule_id: str) -> str:
    """Return the letters of a rule's id.

    >>> prefix_of("CMD-03"), prefix_of("STS-M07")
    ('CMD', 'STS')
    """
    return rule_id.split("-")[0]


def _unknown(kind: str, name: str, known: Sequence[str], allowed: str) -> str:
    matches = difflib.get_close_matches(name.upper(), known, n=1, cutoff=0.5)
    hint = f" (did you mean {matches[0]}?)" if matches else ""
    return f"unknown {kind} {name!r}{hint}; choose from {allowed}"


# -- as text ----------------------------------------------------------------------------------------


def listing(rules: Sequence[Rule], table: RuleTable = AMCI3601) -> str:
    """Return the rules as 80-column text by chapter, with a count at the end."""
    lines: list[str] = []
    chapter = ""
    for rule in rules:
        if chapter_of(rule) != chapter:
            chapter = chapter_of(rule)
            lines += [chapter, "=" * len(chapter), ""]
        lines += [*entry(rule, table), ""]
    return "\n".join([*lines, count(rules)])


def entry(rule: Rule, table: RuleTable = AMCI3601) -> Iterator[str]:
    """Yield the lines of one rule: its text, then its bits, versions and readings, if any."""
    yield f"{rule.id:<{len(INDENT)}}{rule.section}"
    yield from _paragraph(rule.text)
    for title, words in (
        ("sets", ", ".join(table.names(rule.sets))),
        ("clears", ", ".join(table.names(rule.clears))),
        ("with", ", ".join(rule.together_with)),
        ("firmware", firmware_words(rule)),
        ("reading", ", ".join(rule.reading)),
        ("in no image", rule.untestable_because),
    ):
        if words:
            yield from _paragraph(f"{title}: {words}")


def as_row(rule: Rule, table: RuleTable = AMCI3601) -> dict[str, object]:
    """Return a rule for --json."""
    return {
        "id": rule.id,
        "section": rule.section,
        "text": rule.text,
        "sets": table.names(rule.sets),
        "clears": table.names(rule.clears),
        "with": rule.together_with,
        "firmware": firmware_words(rule) or None,
        "readings": rule.reading,
        "in_no_image": rule.untestable_because or None,
    }


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
    """Return a line with the number of rules, and the number of rules that no image can show."""
    hidden = sum(not rule.testable for rule in rules)
    return f"{len(rules)} rule{'' if len(rules) == 1 else 's'}, {hidden} in no image"


# -- the command ------------------------------------------------------------------------------------


def _rules_command(
    table: Annotated[
        Table,
        typer.Argument(metavar="TABLE", help=f"Module: {', '.join(TABLES)}.", show_default=False),
    ],
    ids: Annotated[
        list[str] | None,
        typer.Option("--id", metavar="ID", help="Only this rule, or the rules with this prefix; repeatable."),
    ] = None,
    bit: Annotated[
        str | None,
        typer.Option("--bit", metavar="NAME", help="Only rules that set or clear this status bit."),
    ] = None,
    firmware: Annotated[
        str | None, typer.Option("--firmware", metavar="VERSION", help="Only rules of this firmware version.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """List rules and error bits of a 3601 or a drive, with the manual's section and text.

    Examples:
        scanrack rules amci3601 --bit COMMAND_ERROR

    Exit status: 0 printed, 2 an option can't be used.
    """
    rule_table = TABLES[table]()
    with reported_mistakes():
        rules = with_ids(rule_table.rules.values(), ids or (), rule_table)
        rules = rules if bit is None else with_bit(rules, bit, rule_table)
        if firmware is not None and rule_table is not AMCI3601:
            raise ValueError(f"--firmware {firmware}: the rules of a {table.value} do not differ by version")
        rules = rules if firmware is None else of_firmware(rules, firmware)
    if as_json:
        say_json({"table": table.value, "rules": [as_row(rule, rule_table) for rule in rules]})
    else:
        say(listing(rules, rule_table))


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("rules", no_args_is_help=True)(_rules_command)
