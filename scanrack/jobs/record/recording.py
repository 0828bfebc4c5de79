"""Creates the recorder of a run. It also stores the run's files and settings that determine the result."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from scanrack.runtime.loop.rack import Rack
from scanrack.runtime.loop.scan import ScanLogic
from scanrack.traces.format.layout import SlotInfo
from scanrack.traces.write.recorder import ScanRecorder
from scanrack.traces.write.snapshots import SnapshotLog

from ..load.loading import LoadedRack
from ..load.rungs import is_rungs
from ..trust.attachments import attachment, files_beside, made_by, program_name, retained_tags
from ..trust.owned import check_recording, keeping_of
from .sequence_watch import waiting_in

NOTHING: Mapping[str, str] = MappingProxyType({})


def recorder_for(
    job: LoadedRack,
    rack: Rack,
    trace: Path,
    logic: ScanLogic | None = None,
    *,
    orders: bool = False,
    sequences: bool = False,
    metadata: Mapping[str, str] = NOTHING,
    keep: int | None = None,
    warn: Callable[[str], object] = lambda _cost: None,
) -> ScanRecorder:
    """Return the recorder of a run; `sequence_watch` reports the program's sequences to it.

    Args:
        logic: replacement for the job's logic, such as its debugger.
        orders: whether the rack can be operated while it runs.
        sequences: whether an edit can add sequences to a program without sequences.
        keep: number of earlier recordings to keep; None = as in the rack file.

    Raises:
        OwnedError: the trace would replace an owned file.
        OSError: the trace can't be written.
        ValueError: a tag can't be recorded.
    """
    check_recording(job, trace, keep=keep)
    spec = job.spec
    running = logic or job.logic
    is_python_rack_with_program = job.rack_file == job.program
    tags = None
    if spec.tags:
        from .tag_source import tags_of  # imports the debugger, which a run without tags does not need

        tags = tags_of(running, spec.tags, rack.memory)
        if tags.plan.cost is not None:
            warn(tags.plan.cost)
    beside = [attachment(name, path.read_bytes()) for name, path in files_beside(job).items()]
    return ScanRecorder(
        trace,
        rack.memory,
        [SlotInfo(slot.number, slot.catalog, slot.firmware, slot.words) for slot in rack.slots.values()],
        scan_period_ns=spec.scan_ns,
        seed=spec.seed,
        program=attachment(program_name(job), job.program.read_bytes()),
        rack_file=None
        if is_python_rack_with_program
        else attachment(job.rack_file.name, job.rack_file.read_bytes()),
        attachments=[*beside, *retained_tags(job)],
        metadata={
            **made_by(job),
            "name": spec.name,
            "logic": job.logic_name,
            "controller": spec.controller,
            **({"stubs": "; ".join(job.stubs)} if job.stubs else {}),
            **({"tags": " ".join(spec.tags)} if spec.tags else {}),
            **({"rpi_ns": str(spec.rpi_ns)} if spec.controller == "compactlogix" else {}),
            **metadata,
        },
        tags=tags,
        orders=orders,
        keeping=keeping_of(job, trace, keep),
        sequences=sequences or bool(waiting_in(running)),
        snapshots=_snapshots_of(job, running),
    )


def _snapshots_of(job: LoadedRack, running: Any) -> SnapshotLog | None:
    """Return the snapshots of a ladder program; None for other logic, and for routines in Python.

    There are no snapshots after an edit, so a question about an edited program runs all its scans.
    """
    if not is_rungs(job.logic) or job.logic.functions:
        return None
    from scanrack.ladder.state.snapshots import SavedValues  # only rungs need this import

    def current_memory() -> Any:
        return getattr(getattr(running, "engine", running), "memory", None)  # `running` may be an engine

    memory = current_memory()
    if memory is None:
        return None
    saved = SavedValues(memory)

    def take() -> str | None:
        try:
            return saved.text() if current_memory() is memory else None
        except TypeError:  # text can't represent a value
            return None

    return SnapshotLog(take)
