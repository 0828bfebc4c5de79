"""Data types of RSLogix 500's data files [1747-RM001, "Data files"; 1766-RM001].

| file | element |
|---|---|
| O, I, S, B, N, A | INT |
| F, L, ST | REAL, DINT, STRING |
| T, C, R | three words: bits from bit 15 down, PRE or LEN, ACC or POS |
"""

from __future__ import annotations

from ..types import BOOL, Member, Structure, members_of


def _words(name: str, bits: str, words: str, hidden: str = "") -> Structure:
    flags = (Member(bit, BOOL, bit=15 - number) for number, bit in enumerate(bits.split()))
    return Structure(name, (*flags, *members_of(words)), hidden=members_of(hidden))


SLC_TIMER = _words("SLC_TIMER", "EN TT DN", "INT PRE ACC", "LINT last_ns")
"""PRE and ACC count time bases; `last_ns` is the instant up to which ACC has been counted."""

SLC_COUNTER = _words("SLC_COUNTER", "CU CD DN OV UN UA", "INT PRE ACC")

SLC_CONTROL = _words("SLC_CONTROL", "EN EU DN EM ER UL IN FD", "INT LEN POS")

SLC_TYPES = {kind.name: kind for kind in (SLC_TIMER, SLC_COUNTER, SLC_CONTROL)}
