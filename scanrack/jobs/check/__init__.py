"""Checks a program without running it: a table of facts, and rules about the machine and the program.

facts.py           the table of facts, filled by a collector for each language
rungs, python      the collectors
logic.py           conditions, and whether one can be true
ranges.py          ranges of numbers
choices.py         the possible values of an expression, one by one
groups.py          groups items by a key; finds states that can be reached from a start
subject.py         the data for rules: facts, rack, places in the rack file
rules              the rules, one row each
suppressions.py    comments that suppress findings
alone.py           a ladder program without a rack
check.py           a complete check
"""

from __future__ import annotations

from .alone import load_any
from .check import CheckReport, Finding, ProofFinding, Prover, check_rack, check_replacement, refused
from .facts import FileLine
from .rules import BY_ID, RULES, Rule

__all__ = [
    "BY_ID",
    "RULES",
    "CheckReport",
    "FileLine",
    "Finding",
    "ProofFinding",
    "Prover",
    "Rule",
    "check_rack",
    "check_replacement",
    "load_any",
    "refused",
]
