"""docs/check-rules.md: each rule of `scanrack check` with a good and a bad example, which tests run."""

from collections.abc import Iterator
from pathlib import Path

from check_planted import OF_THE_RACK, PLANTED, Planted
from check_programs import SOUND
from scanrack.jobs.check import RULES, Rule

PAGE = Path(__file__).parents[2] / "docs/check-rules.md"
REMEDY = "python -m tests.tools.generate check"
HEAD = """\
# The rules of `scanrack check`

This page lists what each rule finds and how to fix it, with examples. The examples are lines of whole
programs. `tests/unit/jobs/test_check_planted.py` checks that good lines have no finding, and bad lines the
finding of their section. [Check](check.md) describes how to run the check and how to ignore a finding.

## What counts

* **Constants** of a ladder program are numbers in rungs and initial values of words that no instruction
  writes. In Python, they are numbers and names of the module, and the values of `station` in
  `for station in STATIONS`. Any other value is unknown, and never a finding. Imported files are not read.
  **Ranges** follow constants through MOV, arithmetic and assignments.
* **Output words** of a 3601 are tracked from step to step, whether COP, MOV, bits, `outputs[2] = ...`,
  `load` or a list of steps writes them. The check passes the words of each command to the simulated
  module's own table of refusals. It tries each table element that the words can have. Unknown words
  break no rule.
* **A configuration** is detected when COP or CPS copies it to the slot's output words, MOV writes word 0,
  or `Configure3601` receives it. In a class of `Logic`, every declared configuration is detected.
* **Cleared** means that another instruction clears the bit. Its rung must not need the first scan, another
  command's bit, or a bit of startup or an error (`MODE_CONFIG`, `CONFIG_ERROR`, `COMMAND_ERROR`,
  `POSITION_INVALID`).
* **Steps** are numbers that receive only constants, such as `Step`. A motion must wait for the end of the
  previous motion: for a status bit, a position, a time, Done of a block, or a tag that depends on one.
  A card input does not count as such a wait.
* **A step without an exit** is entered and never left. A startup that ends in a step with conditions does
  not count, and neither does a step with a name such as `done`. In rungs, a step that others select ends
  a job.
* **Exact values** are constants, copies, values that people write, and sums of whole numbers. You can
  compare them for equality, and compare a divisor with 0.
* **Interlocks** apply to two command bits of a 3601, and to two outputs whose names differ in one opposite
  word (Up and Down, Forward and Reverse, Open and Close). The two must exclude each other if card inputs
  can switch both on, even through coils, latches and local names. A contact of one output in the other's
  rung is an interlock.
* **People** read and write tags that the rack file records. They also read and write tags named after HMI,
  SCADA, panel, operator, recipe or setpoint, and all tags of rungs that a Python file creates.
* An `AlwaysOn` bit, an initial value as a setting, `WHILE TRUE` and `while True` are not findings. Lines
  that begin with `not seen` list what the check could not read.

## The rules

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
    lines = [f"\n## {rule.id}\n\n{rule.words[0].upper()}{rule.words[1:]}. **Fix:** {rule.remedy}.\n"]
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
