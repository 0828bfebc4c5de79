"""The rule table with the tests that prove each rule, as a page of Markdown: docs/rules-amci3601.md."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from itertools import groupby

from scanrack.commands.programs.rules import chapter_of, firmware_words
from scanrack.io_images.amci3601 import bit_names
from scanrack.io_images.amci3601.rules import Rule

Proofs = Callable[[str], Sequence[str]]
"""Returns the tests of a rule, "file.py::test_name" each."""

INTRO = """\
# The rules of the AMCI 3601

Every rule of the 3601's manual (revision 3.1) that scanrack knows, in the manual's order and in our own
words. `scanrack rules amci3601` prints the rules in a terminal, `--id CMD` or `--bit COMMAND_ERROR` some of
them. `python -m tests.tools.generate` makes this page from the table and the tests; don't edit it.

How to read a row:

* **Rule**: the id by which `run`, `show` and `drive` name it when it fires, and since which firmware, or
  before which, a module knows it.
* **Says**: where the manual states it, and what it says.
* **Effect**: status bits that are set (+) and cleared (-) when it fires. "with" names the rules that fire
  together with it, since the manual gives the one cause in several lists. Of MOVING_CW and MOVING_CCW, and
  of ACCELERATING and DECELERATING, the one that applies is meant.
* **Readings**: where the manual contradicts itself or is silent, [what scanrack made of it](readings.md).
* **Tests**: the tests that prove it, and in brackets why no image can show whether it holds.
"""

HEAD = ("| Rule | Says | Effect | Readings | Tests |", "|---|---|---|---|---|")


def heading_of(rule: Rule) -> str:
    """Return a rule's section without chapter, numbers and notes; "" where the chapter is all there is."""
    inner = rule.section.partition(", ")[2]
    return re.sub(r"(,? (\d|notes?\b|bits? \d|closing|routine)|^revision).*", "", inner)


def page(rules: Sequence[Rule], proofs: Proofs) -> str:
    """Return rules as a page: a heading a chapter and a section, a row a rule."""
    lines = [INTRO.rstrip("\n")]
    for chapter, of_chapter in groupby(rules, chapter_of):
        lines += ["", f"## {chapter}"]
        for heading, of_section in groupby(of_chapter, heading_of):
            if heading:
                lines += ["", f"### {heading}"]
            lines += ["", *HEAD, *(row(rule, proofs) for rule in of_section)]
    return "\n".join(lines) + "\n"


def row(rule: Rule, proofs: Proofs) -> str:
    """Return one row of the page."""
    known = firmware_words(rule)
    cells = (
        f"**{rule.id}**" + (f"<br>firmware {known}" if known else ""),
        f"*{rule.section}*<br>{rule.text}",
        "<br>".join(_effects(rule)),
        ", ".join(rule.reading),
        "<br>".join(_tests(rule, proofs)),
    )
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


def _effects(rule: Rule) -> Iterator[str]:
    yield from (f"+ {name}" for name in bit_names(rule.sets))
    yield from (f"- {name}" for name in bit_names(rule.clears))
    if rule.together_with:
        yield f"with {', '.join(rule.together_with)}"


def _tests(rule: Rule, proofs: Proofs) -> Iterator[str]:
    """Yield the tests of a rule, each file's after its name, and why there may be none."""
    if not rule.testable:
        yield f"(in no image: {rule.untestable_because})"
    for file, names in groupby(proofs(rule.id), lambda test: test.split("::")[0]):
        yield file
        yield from (f"· {name.split('::', 1)[1]}" for name in names)
