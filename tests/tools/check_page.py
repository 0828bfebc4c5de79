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

What each rule finds, what to do, and a mistake. The examples are lines of whole programs:
`tests/unit/jobs/test_check_planted.py` checks that the good ones have no finding, and the bad ones this one.
[Check](check.md) says how to run it, and how to ignore a finding.

## What counts

* **Constants** of a ladder program are numbers in rungs and initial values of words that no instruction
  writes; of Python, numbers and names of the module, and what `for station in STATIONS` may be. Any
  other value is unknown, and legal. Imported files are not read. **Ranges** follow constants through
  MOV, arithmetic and assignments.
* **Output words** of a 3601 are followed from step to step, whether COP, MOV, bits, `outputs[2] = ...`,
  `load` or a list of steps writes them. The words with which a command is given are asked of the
  simulated module's own table of refusals, for each element of a table that may be in them; words that
  are not known break no rule.
* **A configuration** is seen where COP or CPS copies it to the slot's output words, MOV writes word 0,
  or `Configure3601` gets it. Of a class of `Logic` everything that it declares is known.
* **Taken back**: another instruction clears the bit, on a rung that needs neither the first scan, nor a
  bit of start-up or an error (`MODE_CONFIG`, `CONFIG_ERROR`, `COMMAND_ERROR`, `POSITION_INVALID`), nor
  another command's bit.
* **Steps**: a number that only gets constants, such as `Step`. A motion must wait for the end of the one
  before it: for a status bit, a position, a time, Done of a block, or a tag that depends on one. An
  input of a card is no such wait.
* **A step without an exit** is entered and never left. A start-up that ends in a step with conditions of its
  own is none, nor is a step with a name such as `done`; in rungs, a step that others choose ends a job.
* **Exact** are constants, copies, what people write, and sums of whole numbers: they may be compared for
  equality, and a divisor with 0.
* **Interlocks**: two command bits of a 3601, and two outputs whose names differ in one opposite word (Up
  and Down, Forward and Reverse, Open and Close), must exclude each other where inputs of cards switch
  both on, also behind coils, latches and local names. An output's contact in the other's rung is an
  interlock.
* **People** read and write tags that the rack file records, tags called after HMI, SCADA, panel,
  operator, recipe or setpoint, and all tags of rungs that a Python file makes.
* An `AlwaysOn` bit, an initial value as a setting, `WHILE TRUE` and `while True` are no findings. Lines
  that begin with `not seen` name what the check could not read.

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
