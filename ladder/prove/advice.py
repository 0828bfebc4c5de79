"""Advice on an undecided claim: one sentence that depends on the reason."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

MOST_NAMES = 3
"""Maximum number of tags in a sentence."""

_WAYS: tuple[tuple[str, Callable[[re.Match[str], str], str]], ...] = (
    (
        r"(?P<what>.*), not modeled",
        lambda found, _: (
            f'{found["what"]} may leave anything: say with assume = ["..."] what it gives, '
            "or state no property of it"
        ),
    ),
    (
        r"no run of (?P<scans>[\d,]+) scans? keeps what is assumed",
        lambda found, _: f"the assumptions leave no run of {found['scans']} scans: take one of them out",
    ),
    (
        r"(?P<where>.*): .*(?:more than \d+ passes|calls more than \d+ deep|jump backwards)",
        lambda found, _: (
            f"nothing is known after {found['where']}: let constants bound its loop, "
            "64 passes at most, and nest fewer calls"
        ),
    ),
    (
        r"a fault ends the run: (?P<fault>.*)",
        lambda found, _: f'fix the fault first, or exclude it with assume = ["..."]: {found["fault"]}',
    ),
    (
        r"the processor writes (?P<what>.*) itself",
        lambda found, _: (
            f"no proof knows what the processor writes to {found['what']}: state no property of it"
        ),
    ),
    (
        r".*a defect of scanrack",
        lambda _found, _: "report it with the program: the relation and the program differ",
    ),
    (
        r".*the solver's fuse.*",
        lambda _found, names: f'the solver gave up: bound {names} with assume = ["..."], or narrow scan_ms',
    ),
    (
        r"the limit of .*",
        lambda _found, names: (
            "no run breaks it within the limit and no induction proves it: say with "
            f'assume = ["..."] what bounds {names}, or shorten the times that it waits for'
        ),
    ),
    (
        r"(?P<what>.*)",
        lambda found, _: f"the relation does not follow {found['what']}: state no property of what it writes",
    ),
)
"""Patterns of reasons, the most severe first, each with a function that returns its advice."""


def advice(blame: Sequence[str], deciding: Sequence[str]) -> str:
    """Return the advice for the most severe reason; "" if there is no reason.

    >>> advice(["the limit of work, in scan 31"], ["Boxes", "Full"])
    'no run breaks it within the limit and no induction proves it: say with assume = ["..."] what bounds \
Boxes and Full, or shorten the times that it waits for'

    Args:
        blame: see `Verdict.blame`.
        deciding: names of the tags that decide the claim.
    """
    names = " and ".join(deciding[:MOST_NAMES]) or "the numbers that decide it"
    for pattern, sentence in _WAYS:
        for reason in blame:
            match = re.fullmatch(pattern, reason)
            if match is not None:
                return sentence(match, names)
    return ""
