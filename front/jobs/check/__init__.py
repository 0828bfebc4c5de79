"""Checks of a rack without running it: rules about the machine, the wiring and the program.

facts.py            facts of a program in any language
ladder_facts.py     facts of rungs
output_writes.py    writes of rungs to the output words of 3601s
python_facts.py     facts of a Python program's text
sequence_facts.py   facts of a program with sequences: its class, and its text
sequence_calls.py   calls in it whose constants an axis refuses
loops.py            loops in it that never wait
rules.py            the rules, one row each; they read the facts and the rack
"""

from __future__ import annotations

from .facts import FileLine
from .rules import RULES, CheckReport, Finding, check_rack

__all__ = ["RULES", "CheckReport", "FileLine", "Finding", "check_rack"]
