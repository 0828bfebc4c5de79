"""All claims of a subject, one after the other; each scenario is done on the rack, and written."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from ...ladder.prove.answers import LIMITS, Answer, answer
from ...ladder.prove.induction import Limits
from ...runtime.loop.faults import CpuFault
from ...runtime.loop.pace import wall_ns
from ..fuzz.folder_lock import locked, write_text
from ..trust.owned import in_use
from .on_rack import OnRack, record, replay_on_rack
from .scenario import on_scans_of
from .subject import Subject

SCENARIO, TRACE = "scenario.json", "trace.mcap"
"""Files of a refuted claim, in a folder of its name."""

Progress = Callable[[str, int, int], object]
"""Called before each claim: its name, its number from 1, how many there are."""


def no_progress(_name: str, _number: int, _of: int) -> None:
    """Show nothing."""


@dataclass(frozen=True, slots=True)
class Result:
    """An answer with the time that it took, what the rack did, and its scenario's file."""

    answer: Answer
    spent_ns: int
    rack: OnRack | None = None
    scenario: Path | None = None

    @property
    def name(self) -> str:
        """Name of the claim."""
        return self.answer.claim.name


def prove_all(
    subject: Subject, folder: Path, held: ExitStack, progress: Progress = no_progress, limits: Limits = LIMITS
) -> Iterator[Result]:
    """Decide the claims of a subject.

    Args:
        folder: gets a folder for each claim with a scenario; made, and locked, with the first one.
        held: releases the folder.

    Raises:
        ValueError: the folder has other files, or another process uses it.
        OSError: a file can't be written.
    """
    hold = cache(lambda: held.enter_context(locked(folder)))
    claims = subject.program.properties
    for number, each in enumerate(claims, start=1):
        progress(each.claim.name, number, len(claims))
        start_ns = wall_ns()
        found = answer(subject.problem, subject.program, each, limits)
        if not found.steps:
            yield Result(found, wall_ns() - start_ns)
            continue
        rack = replay_on_rack(subject, each, found.scans)
        hold()
        file = _written(subject, found, rack, folder / slug(each.claim.name))
        yield Result(found, wall_ns() - start_ns, rack, file)


def slug(name: str) -> str:
    """Return the name of a claim's folder.

    >>> slug("lost position"), slug("never Fwd AND Rev (2)"), slug("??")
    ('lost_position', 'never_Fwd_AND_Rev_2', 'claim')
    """
    return re.sub(r"\W+", "_", name).strip("_")[:60] or "claim"


def _written(subject: Subject, found: Answer, rack: OnRack | None, folder: Path) -> Path:
    """Write the scenario, and its recording if the rack breaks the claim; return the scenario's path."""
    folder.mkdir(parents=True, exist_ok=True)
    job, layout = subject.job, subject.problem.lowered.layout
    if rack is None:
        orders = on_scans_of(layout, found.scans, 1_000_000).scenario(1_000_000)
    else:
        orders = rack.scenario.scenario(job.spec.scan_ns)
    file = write_text(folder / SCENARIO, json.dumps(orders.to_json(), indent=1) + "\n", in_use(job))
    if rack is not None and rack.confirmed:
        with suppress(CpuFault):  # the recording ends with the fault
            record(job, rack, folder / TRACE)
    return file
