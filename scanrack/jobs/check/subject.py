"""The input to the rules: a rack, the facts of its program, and line numbers in the rack file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

from scanrack.io_images.amci3601 import Configuration, Limits
from scanrack.io_images.amci3601.words import Profile, is_stepper
from scanrack.io_images.image import Image
from scanrack.runtime.config.rackspec import SlotSpec, profile_in
from scanrack.runtime.config.tomllines import KeyLines, KeyPath

from ..load.loading import LoadedRack
from .facts import Access, Command, Facts, FileLine, Role, SentCommand, Variable
from .groups import grouped
from .module_kinds import NEWEST
from .words import SentImage, sent_images


@dataclass(frozen=True)
class Subject:
    """A rack together with the facts of its program."""

    job: LoadedRack
    facts: Facts
    lines: KeyLines | None  # of the rack file; None for a rack in Python, or without a rack
    alone: bool = False  # whether there is no rack, and therefore no machine

    def place(self, *path: str | int) -> FileLine:
        """Return the file and line of a key in the rack file; line 1 for a rack in Python."""
        key: KeyPath = path
        return FileLine(str(self.job.rack_file), 1 if self.lines is None else self.lines.line(key))

    @property
    def steppers(self) -> Iterator[tuple[int, SlotSpec]]:
        """The slots with the words of a 3601 and a simulated machine, each with its rack file index."""
        for index, slot in enumerate(() if self.alone else self.job.spec.slot):
            if is_stepper(slot.words) and not slot.is_live:
                yield index, slot

    def firmware(self, slot: int) -> str:
        """Return the firmware of the module in a slot, as given in the rack file."""
        return next((spec.firmware for spec in self.job.spec.slot if spec.number == slot), NEWEST)

    def profile(self, slot: int | None) -> Profile:
        """Return the profile of the module in a slot, see `profile_in`."""
        return profile_in(self.job.spec.slot, slot)

    def sent_to(self, slot: int | None, sent: Sequence[SentCommand]) -> list[SentCommand]:
        """Return the words sent to a slot; if there are none, the words sent to an unknown slot."""
        to_slot = [command for command in sent if command.slot == slot]
        return to_slot or [command for command in sent if command.slot is None]

    def configurations(self, slot: int | None) -> list[Configuration]:
        """Return the valid configurations that a slot may receive."""
        if slot not in self._configurations:
            commands = self.sent_to(slot, self.facts.configurations)
            if slot is None and not commands:
                commands = self.facts.configurations
            limits = self.profile(slot).limits
            configurations = dict.fromkeys(_configuration(command, limits) for command in commands)
            self._configurations[slot] = [valid for valid in configurations if valid is not None]
        return self._configurations[slot]

    @cached_property
    def _configurations(self) -> dict[int | None, list[Configuration]]:
        """The results of `configurations`, by slot."""
        return {}

    @cached_property
    def images(self) -> list[SentImage]:
        """The output images that send commands."""
        return list(sent_images(self.facts.writes, self.facts.actions))

    @cached_property
    def by_variable(self) -> list[tuple[Variable, list[Access]]]:
        """Each variable with its accesses."""
        return self.facts.by_variable()

    @cached_property
    def own_variables(self) -> list[tuple[Variable, list[Access]]]:
        """The variables that are not inputs, with their accesses; empty if some code is not analyzed."""
        pairs = () if self.facts.reads_all else self.by_variable
        return [(variable, accesses) for variable, accesses in pairs if variable.role is not Role.INPUT]

    @cached_property
    def by_key(self) -> dict[str, list[Access]]:
        """The accesses to each variable, by its key."""
        return self.facts.by_key()

    def by_axis(self) -> Iterator[list[Command]]:
        """Yield the commands of each axis."""
        yield from grouped(self.facts.commands, lambda command: command.axis).values()


def _configuration(sent: SentCommand, limits: Limits) -> Configuration | None:
    """Return the configuration in sent words; None if words are missing or out of range."""
    if len(sent.words) < 8:
        return None
    signed = [word - 0x10000 if word > 0x7FFF else word for word in sent.words]
    try:
        return Configuration.from_image(Image(signed), limits=limits)
    except ValueError:
        return None
