"""The registry records of the adapters; slow modules are imported on first use."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from scanrack.io_images.amci3601 import StatusMsw, StatusView
from scanrack.io_images.amci3601.words import WORDS_3601
from scanrack.io_images.pmc006.frame import FACTORY_ADDRESS
from scanrack.io_images.site import SettingError

from ...loop.module import Module
from ...machine import Machine, MachineSpec
from ..record import LiveModule, LivePort, ModuleRecord, Options, Trait

if TYPE_CHECKING:
    from .module import AdapterKind

ROUND_TRIP_MS = 400
"""Longer than the response time of the slowest command, a configuration."""


def adapter_record(
    name: str, kind: Callable[[], AdapterKind[Any]], *, factory_address: int, highest_address: int
) -> ModuleRecord:
    """Return the record of an adapter, which acts as a 3601 with firmware 4.1."""

    def make(firmware: str, machine: MachineSpec, seed: int, options: Options, wiring: str | None) -> Module:
        """Return the adapter with a simulated device; refuse any other firmware and any wiring."""
        if firmware != "4.1":
            raise SettingError("firmware", f"firmware {firmware}: {name} acts as firmware 4.1")
        if wiring is not None:
            raise SettingError("wiring", f"wiring {wiring}: {name} has no wiring option; remove it")
        return kind().simulated(Machine(machine, seed), options)

    def open_live(port: str, address: int, options: Options) -> LiveModule:
        from .live import open_adapter

        return open_adapter(kind(), port, address, options)

    return ModuleRecord(
        name=name,
        make=make,
        words=lambda _options: WORDS_3601,
        has_firmware=True,
        status=lambda image, _words: StatusView(image),
        live=LivePort(opened=open_live, factory_address=factory_address, highest_address=highest_address),
        traits=frozenset({Trait.MACHINE, Trait.LINE}),
        capabilities=lambda: "\n".join(_refusals(kind())) + "\n",
        option_table=lambda: kind().options,
        round_trip_ms=ROUND_TRIP_MS,
    )


def _refusals(kind: AdapterKind[Any]) -> Iterator[str]:
    """Yield the lines of an adapter's table of refusals, in Markdown."""
    from ..amci3601 import Feature
    from .capabilities import CONFIG_ERROR

    yield from ("| request | reason of the refusal | error bits |", "|---|---|---|")
    for limit in kind.capabilities.configuration_rows:
        yield f"| configuration: {limit.name} | {limit.reason} | {_bit_names(CONFIG_ERROR)} |"
    for row in kind.capabilities.command_rows:
        features = row.features
        request = features.value if isinstance(features, Feature) else f"{row.name} of any motion"
        yield f"| {request} | {row.reason} | {_bit_names(row.bits)} |"


def _bit_names(bits: int) -> str:
    return ", ".join(str(bit.name) for bit in StatusMsw if bit & bits)


def _pcl601() -> AdapterKind[Any]:
    from .pcl601.module import PCL601

    return PCL601


def _pmc006() -> AdapterKind[Any]:
    from .pmc006.module import PMC006

    return PMC006


def _amci_drive() -> AdapterKind[Any]:
    from .amci_drive.module import AMCI_DRIVE

    return AMCI_DRIVE


RECORDS = (
    adapter_record("pcl601-adapter", _pcl601, factory_address=1, highest_address=99),
    adapter_record("pmc006-adapter", _pmc006, factory_address=FACTORY_ADDRESS, highest_address=120),
    adapter_record("amci-drive", _amci_drive, factory_address=1, highest_address=247),
)
