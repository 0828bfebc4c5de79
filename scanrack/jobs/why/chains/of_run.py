"""The chain of causes in a recorded run, such as a failing run that `fuzz` found."""

from __future__ import annotations

from scanrack.ladder import LadderLogic
from scanrack.ladder.debug import CauseLink, Debugger
from scanrack.traces.replay import PackedTrace

from ...load.loading import LoadedRack
from ..answer import Why
from ..followed import run_rungs
from ..traced_run import Load


def chain_of(
    recording: PackedTrace,
    job: LoadedRack,
    name: str,
    row: int | None = None,
    *,
    load: Load | None = None,
    deep: bool = False,
) -> CauseLink:
    """Return the chain of causes of a value in a recorded run, back to its first cause.

    The program runs again on the recorded inputs; `CauseLink.walk` yields the links.

    Args:
        job: the rack and its program.
        name: a tag, a bit or word of an image, a value of a Python program, or a sequence.
        row: row of the scan; by default the last one.
        load: reloads a Python program; None for a ladder program, or if only images are explained.
        deep: whether to include Add-On Instruction rungs.

    Raises:
        ValueError: the name is unknown.
    """
    row = len(recording.scans) - 1 if row is None else row
    if not isinstance(job.logic, LadderLogic):
        return Why(recording, row, job.spec, load).chain(name, deep=deep)
    debugger = Debugger(job.logic)
    run_rungs(recording, job.spec, debugger, row)
    return Why(recording, row, job.spec, None, debugger).chain(name, deep=deep)
