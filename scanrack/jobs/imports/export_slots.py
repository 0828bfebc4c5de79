"""Writes the slots of a rack file for an export.

| the export has | the rack file has |
|---|---|
| a 3601: by name, by its words, or by the user's choice | `amci3601` |
| a card that scanrack simulates | that card |
| any other module | a comment: its tags are memory of the real size |
| no simulated module | `amci3601` in the first free slot: a rack needs one module |

If two modules share a slot, the rack file has the first.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from scanrack.io_images.cards import KINDS
from scanrack.runtime.modules.record import Trait
from scanrack.runtime.modules.registry import OWN

from .toml_text import comment, text

STEPPER = "amci3601"


@dataclass(frozen=True, slots=True)
class ExportSlot:
    """A slot of an export."""

    number: int  # slot number, from 1
    catalog: str
    name: str = ""  # name of the module; "" without a name
    tags: str = ""  # names and sizes of its inputs and outputs
    module: str | None = None  # its name in a rack file; None if it is not simulated
    why: str = ""  # reason for the choice of `module`; "" if the catalog number determines it

    def __str__(self) -> str:
        return f"slot {self.number}: {f'{self.catalog} {self.name}'.strip() or 'a module'}"


def simulated(catalog: str) -> str | None:
    """Return the rack file's module name for a catalog number; None if the module is not simulated.

    >>> simulated("1769-IQ16/A"), simulated("1769-IF8")
    ('1769-IQ16', None)
    """
    name = catalog.partition("/")[0].upper()
    return next((own_name for own_name in OWN if own_name.upper() == name), None)


def with_steppers(slots: Iterable[ExportSlot], named: Collection[str]) -> list[ExportSlot]:
    """Return the slots; the modules that the user names become 3601s.

    Args:
        named: module names or slot numbers.

    Raises:
        ValueError: the export lacks one of the named modules.
    """
    unmatched = {name.upper(): name for name in named}
    marked_slots = []
    for slot in slots:
        stepper = unmatched.pop(slot.name.upper(), None) if slot.name else None
        stepper = unmatched.pop(str(slot.number), stepper)
        why = f"--stepper {stepper} names it"
        marked_slots.append(slot if stepper is None else replace(slot, module=STEPPER, why=why))
    if unmatched:
        modules = [f"{slot.name or slot.catalog} in slot {slot.number}" for slot in marked_slots]
        raise ValueError(
            f"--stepper {next(iter(unmatched.values()))}: the export has no such module; "
            f"it has {', '.join(modules) or 'none'}"
        )
    return marked_slots


def slot_tables(slots: Sequence[ExportSlot]) -> Iterator[str]:
    """Yield the lines of a rack file's slots, with the decisions as comments."""
    used_numbers: set[int] = set()
    for slot in sorted(slots, key=lambda slot: slot.number):
        yield ""
        if slot.number in used_numbers:
            yield comment(f"{slot}: left out, because the slot already has a module")
        elif slot.module is None:
            yield comment(f"{slot}: not simulated, its tags are memory{slot.tags and f': {slot.tags}'}")
        else:
            yield from _table(slot)
        used_numbers.add(slot.number)
    if not any(slot.module for slot in slots):
        free = next(number for number in range(1, len(used_numbers) + 2) if number not in used_numbers)
        yield ""
        yield comment("No module of the export is simulated. A rack needs one: this one is in a free slot.")
        yield from _table(ExportSlot(free, "", module=STEPPER))


def _table(slot: ExportSlot) -> Iterator[str]:
    """Yield the lines of a simulated slot: a comment on its module, its table, and settings to complete."""
    assert slot.module is not None
    if slot.catalog or slot.name:
        yield comment(str(slot) + (f": treated as a 3601, since {slot.why}" if slot.why else ""))
    yield "[[slot]]"
    yield f"number = {slot.number}"
    yield f"module = {text(slot.module)}"
    yield from _wiring(slot.module)


def _wiring(module: str) -> Iterator[str]:
    """Yield commented-out settings for the user to complete."""
    if Trait.MACHINE in OWN[module].traits:
        yield "# [slot.machine]"
        yield "# switches = ["
        yield '#     { input = "home", first = -1500, last = -1300 },'
        yield '#     { input = "cw_limit", first = 12000 },'
        yield "# ]"
    elif module in KINDS and KINDS[module].inputs:
        yield "# [slot.options]"
        yield "# inputs = { start = 0 }"
        yield '# timeline = [{ at_ms = 500, input = "start", for_ms = 200 }]'
    elif module in KINDS and KINDS[module].channels_in:
        yield "# [slot.options]"
        yield "# inputs = { level = 0 }"
        yield '# timeline = [{ at_ms = 500, input = "level", value = 4000 }]'


def differences(slots: Iterable[ExportSlot], rack: Iterable[tuple[int, str]]) -> Iterator[str]:
    """Yield a sentence for each difference between a rack and the export's module tree.

    Args:
        rack: number and module of each slot in the rack.
    """
    slots_by_number = {slot.number: slot for slot in slots}
    for number, module in rack:
        slot = slots_by_number.get(number)
        if slot is None or module in (slot.module, simulated(slot.catalog)):
            continue
        if slot.module is None and simulated(slot.catalog) is None and slot.catalog in GENERIC_CATALOGS:
            continue  # a generic profile: only the user knows the module
        yield f"{slot} in the export, but {module} in the rack: the slot has the tags of the {module}"


GENERIC_CATALOGS = ("1769-MODULE", "OTHER")
"""Catalog numbers of generic profiles."""
