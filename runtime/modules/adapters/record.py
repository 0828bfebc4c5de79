"""The common part of the adapters' records."""

from __future__ import annotations

from collections.abc import Callable

from ....io_images.amci3601.words import WORDS_3601
from ...loop.module import Module
from ...machine import Machine, MachineSpec
from ..record import LivePort, ModuleRecord, Options, Trait

ROUND_TRIP_MS = 400
"""Longer than the slowest command, a configuration, takes until its answer."""


def adapter_record(
    name: str,
    made: Callable[[Machine, Options], Module],
    live: LivePort,
    capabilities: Callable[[], str],
) -> ModuleRecord:
    """Return the record of an adapter, which acts as a 3601 of firmware 4.1.

    Args:
        made: makes one with a simulated controller.
        capabilities: the table of its refusals.
    """

    def make(firmware: str, machine: MachineSpec, seed: int, options: Options, wiring: str | None) -> Module:
        if firmware != "4.1":
            raise ValueError(f"firmware {firmware}: {name} answers as 4.1")
        if wiring is not None:
            raise ValueError(f"wiring {wiring}: {name} has none; leave it out")
        return made(Machine(machine, seed), options)

    return ModuleRecord(
        name=name,
        make=make,
        words=lambda _options: WORDS_3601,
        live=live,
        traits=frozenset({Trait.MACHINE, Trait.LINE}),
        capabilities=capabilities,
        round_trip_ms=ROUND_TRIP_MS,
    )
