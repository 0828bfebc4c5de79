"""The registry records of the networked drives, which have ten words in each direction."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

from scanrack.io_images.drives.models import MODELS, Model
from scanrack.io_images.site import SettingError

from ...loop.exposed import Conditions
from ...loop.module import Module
from ...machine import Machine, MachineSpec
from ...machine.spec import input_name
from ..record import ModuleRecord, Options, Trait

if TYPE_CHECKING:
    from .drive import DriveUnit
    from .drive_options import DriveOptions


def make(
    model: Model, firmware: str, machine: MachineSpec, seed: int, options: Options, wiring: str | None
) -> Module:
    """Make a simulated drive with a machine.

    Args:
        seed: seed of the machine's random numbers.
        options: options of the model, by name; see `SmdOptions`.

    Raises:
        ValueError: an unknown option, or a wiring, which drives do not have.
    """
    from .drive import DriveUnit

    if wiring is not None:
        raise SettingError("wiring", f"wiring {wiring}: a {model.title} has no wiring option; remove it")
    return DriveUnit(model, Machine(machine, seed), options)


def _option_table(model: Model) -> type[DriveOptions]:
    from .drive_options import options_of

    return options_of(model)


def _machine_inputs(model: Model, options: Options) -> Mapping[str, str]:
    """Return the machine's inputs with the drive's names for them, in the order of the terminals.

    Several terminals may share an input of the machine.
    """
    terminals = _option_table(model).of(options).terminals(model)
    drive_names: dict[str, list[str]] = {}
    for bit, drive_name in zip(terminals, model.input_names, strict=True):
        names = drive_names.setdefault(input_name(bit), [])
        if drive_name != input_name(bit):
            names.append(drive_name)
    return {name: ", ".join(names) for name, names in drive_names.items()}


def _conditions(drive: DriveUnit) -> Conditions:
    from .conditions import DriveConditions

    return DriveConditions(drive)


def _states() -> Mapping[str, Sequence[str]]:
    from .conditions import states

    return states()


def _record(model: Model) -> ModuleRecord:
    return ModuleRecord(
        name=model.name,
        make=partial(make, model),
        words=lambda _options: model.words,
        traits=frozenset({Trait.MACHINE, Trait.SLIPS}),
        option_table=partial(_option_table, model),
        conditions=_conditions,
        states=_states,
        machine_inputs=partial(_machine_inputs, model),
    )


RECORDS = tuple(map(_record, MODELS.values()))
