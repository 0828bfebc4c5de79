"""Advice on an undecided claim: one sentence, chosen by the reason."""

from __future__ import annotations

import re
from collections.abc import Sequence

MOST_NAMES = 3
"""Maximum number of tags in a sentence."""

_ADVICE: tuple[tuple[str, str], ...] = (
    (
        r"(?P<instruction>.*), not modeled",
        'proofs allow any result of {instruction}: assume its results with assume = ["..."], '
        "or state no property of it",
    ),
    (
        r"no run of (?P<scans>[\d,]+) scans? keeps the assumptions",
        "the assumptions exclude every run of {scans} scans: remove one of them",
    ),
    (
        r"(?P<place>.*): .*(?:more than \d+ passes|calls more than \d+ deep|jump backwards)",
        "nothing is known after {place}: limit its loop to 64 passes with constants, and nest fewer calls",
    ),
    (
        r"a fault ends the run: (?P<fault>.*)",
        'fix the fault first, or exclude it with assume = ["..."]: {fault}',
    ),
    (
        r"the processor writes (?P<tags>.*) itself",
        "proofs can't predict the values that the processor writes to {tags}: state no property of them",
    ),
    (
        r".*a defect of scanrack",
        "report it with the program: the relation and the program differ",
    ),
    (
        r".*the solver's fuse.*",
        'the solver gave up: limit {names} with assume = ["..."], or narrow scan_ms',
    ),
    (
        r"the limit of .*",
        "no run breaks it within the limit and no induction proves it: limit {names} with "
        'assume = ["..."], or shorten the times that it waits for',
    ),
    (
        r"(?P<instruction>.*)",
        "the relation does not follow {instruction}: state no property of the tags that it writes",
    ),
)
"""Patterns of reasons, the most severe first, each with its advice; `names` are the deciding tags."""


def advice(blame: Sequence[str], deciding: Sequence[str]) -> str:
    """Return the advice for the most severe reason; "" if there is no reason.

    >>> advice(["the limit of work, in scan 31"], ["Boxes", "Full"])
    'no run breaks it within the limit and no induction proves it: limit Boxes and Full with \
assume = ["..."], or shorten the times that it waits for'

    Args:
        blame: see `Verdict.blame`.
        deciding: names of the tags that decide the claim.
    """
    names = " and ".join(deciding[:MOST_NAMES]) or "the numbers that decide it"
    for pattern, sentence in _ADVICE:
        for reason in blame:
            match = re.fullmatch(pattern, reason)
            if match is not None:
                return sentence.format(names=names, **match.groupdict())
    return ""
