"""Data types of RSLogix 500's data files [1747-RM001, "Data files"; 1766-RM001].

| file | element |
|---|---|
| O, I, S, B, N, A | INT |
| F, L, ST | REAL, DINT, STRING |
| T, C, R | three words: bits from bit 15 down, PRE or LEN, ACC or POS |
"""

from __future__ import annotations

from ..types import BOOL, INT, LINT, Member, Structure


def _words(name: str, bits: str, *words: str, hidden: tuple[Member, ...] = ()) -> Structure:
    flags = (Member(bit, BOOL, bit=15 - number) for number, bit in enumerate(bits.split()))
    return Structure(name, (*flags, *(Member(word, INT) for word in words)), hidden=hidden)


SLC_TIMER = _words("SLC_TIMER", "EN TT DN", "PRE", "ACC", hidden=(Member("last_ns", LINT),))
"""PRE and ACC count time bases; `last_ns` is the instant up to which ACC has been counted."""

SLC_COUNTER = _words("SLC_COUNTER", "CU CD DN OV UN UA", "PRE", "ACC")

SLC_CONTROL = _words("SLC_CONTROL", "EN EU DN EM ER UL IN FD", "LEN", "POS")

SLC_TYPES = {each.name: each for each in (SLC_TIMER, SLC_COUNTER, SLC_CONTROL)}
