"""docs/check-rules.md: each rule of `scanrack check` with a good and a bad example, which tests run."""

from collections.abc import Iterator
from pathlib import Path

from check_planted import OF_THE_RACK, PLANTED, Planted
from check_sound import SOUND
from scanrack.jobs.check import RULES, Rule

PAGE = Path(__file__).parents[2] / "docs/check-rules.md"
REMEDY = "python -m tests.tools.generate check"
HEAD = """\
# The rules of `scanrack check`

What each rule finds, what to do, and a mistake. The examples are lines of whole programs:
`tests/unit/jobs/test_check_planted.py` checks that the good ones have no finding, and the bad ones this one.
[Check](check.md) says how to run it, and how to ignore a finding.

| rule | level | finds | what to do |
|---|---|---|---|
"""


def page() -> str:
    """Return the page."""
    rows = "".join(
        f"| [`{each.id}`](#{each.id}) | {each.level} | {each.words} | {each.remedy} |\n" for each in RULES
    )
    return HEAD + rows + "".join(_section(each) for each in RULES)


def _section(rule: Rule) -> str:
    """Return a rule's section, with an example per language."""
    lines = [f"\n## {rule.id}\n\n{rule.words[0].upper()}{rule.words[1:]}: {rule.remedy}.\n"]
    if rule.id in OF_THE_RACK:
        good, bad = OF_THE_RACK[rule.id]
        lines.append(f"\n    good: {good}\n    bad:  {bad}\n")
    seen = set()
    for each in PLANTED:
        language = _language(each.program)
        if each.rule == rule.id and language not in seen:
            seen.add(language)
            lines.append("".join(_example(each, language)))
    return "".join(lines)


def _language(program: str) -> str:
    """Return the language of a sound program."""
    text = SOUND[program]
    if ".py" in program:
        return "a sequence" if "@sequence" in text else "rungs in Python" if "rung(" in text else "Python"
    return "structured text" if "Main ST" in text else "rungs"


def _example(planted: Planted, language: str) -> Iterator[str]:
    where = " on a CompactLogix" if planted.controller else ""
    yield f"\nIn {language}{where}:\n\n"
    old, new = planted.old, planted.new
    for name, text in (("good:", old), ("bad:", new)):
        lines = [line.strip() for line in text.splitlines() if line.strip()] or ["(nothing)"]
        yield from (f"    {name:<6}{line}\n" for line in lines)
