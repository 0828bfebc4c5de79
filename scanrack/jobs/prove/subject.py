"""The subject of a proof: a rack, program or export with its monitors, as a problem for the prover."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from scanrack.io_images.amci3601.contracts import contracts_of
from scanrack.io_images.amci3601.words import is_stepper
from scanrack.ladder.prove.contracts import KeptBy
from scanrack.ladder.prove.monitors import MonitoredProgram
from scanrack.ladder.prove.system import Contract, ProgramSystem, ScanBounds
from scanrack.runtime.modules.record import Trait

from ..check.alone import load_any
from ..load.claims import with_monitors
from ..load.loading import LoadedRack
from ..load.program import split_address


@dataclass(frozen=True, slots=True)
class ProofSubject:
    """The program of a proof, with its monitors.

    Attributes:
        name: stem of its file.
        assumed: assumptions of the proofs about the modules, one sentence each.
    """

    name: str
    job: LoadedRack
    program: MonitoredProgram
    problem: ProgramSystem
    assumed: tuple[str, ...]


def subject_of(file: str) -> ProofSubject:
    """Load a rack with its program, or only a program or export.

    Raises:
        ValueError: a file is invalid, or no proof covers a part of the program; the message names it.
    """
    job, _ = load_any(file)
    return replace(subject_of_job(job), name=Path(split_address(file)[0]).stem)


def subject_of_job(
    job: LoadedRack, beside: ProgramSystem | None = None, bounds: ScanBounds | None = None
) -> ProofSubject:
    """Return the subject of a loaded rack.

    Args:
        beside: another problem that shares its terms with this one.
        bounds: bounds of the time between scans; None = as in the rack file.

    Raises:
        ValueError: no proof covers a part of the program; the message names it.
    """
    program = with_monitors(job)
    prove_spec = job.spec.prove
    bounds = bounds or bounds_of(job)
    rows = list(_contracts(job, program, bounds))
    problem = ProgramSystem(
        program.program,
        bounds,
        free=prove_spec.free,
        written_outside=prove_spec.written_outside,
        assume=program.assume,
        contracts=[contract for contract, _ in rows],
        happens=prove_spec.happens,
        beside=beside,
    )
    return ProofSubject(job.rack_file.stem, job, program, problem, tuple(sentence for _, sentence in rows))


def bounds_of(job: LoadedRack) -> ScanBounds:
    """Return the times between scans that proofs cover, from 0 ms for a rack with scans below 1 ms."""
    shortest, longest = job.spec.prove.scan_ms
    if shortest == 1 and job.spec.scan_ns < 1_000_000:
        shortest = 0
    return ScanBounds.of(shortest, longest, job.spec.scan_ns)


def _contracts(
    job: LoadedRack, program: MonitoredProgram, bounds: ScanBounds
) -> Iterator[tuple[Contract, str]]:
    """Yield the contract of the inputs of each 3601 in use, with a sentence about it."""
    at_rpi = job.spec.controller == "compactlogix"
    each_update = not at_rpi or bounds.high_ms * 1_000_000 <= job.spec.rpi_ns
    used = {leaf.slot for leaf in program.program.build().layout.images}
    for slot in job.spec.slot:
        if slot.number in used and is_stepper(slot.words):
            adapter = slot.has(Trait.LINE)
            rows = contracts_of(slot.options, each_update=each_update, adapter=adapter)
            sentence = f"slot {slot.number} keeps {len(rows)} contracts of the 3601"
            yield KeptBy(slot.number, rows, at_rpi and each_update), sentence
