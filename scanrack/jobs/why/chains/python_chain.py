"""The part of a Python program's chains that `waiting` and `unwritten` use."""

from __future__ import annotations

from dataclasses import field

from scanrack.io_images.addresses import Address, parse_address
from scanrack.io_images.dataclass import dataclass
from scanrack.ladder.debug import CauseLink
from scanrack.runtime.config.rackspec import RackSpec

from ..bits import Bits
from ..chain import RackChain
from ..source.class_names import Names
from ..traced_run import Load, Look, run_again


@dataclass(slots=True)
class PythonChain(RackChain):
    """Makes chains through a recording and its Python program; see `ProgramChain`."""

    spec: RackSpec = field(kw_only=True)
    load: Load = field(kw_only=True)
    names: Names = field(kw_only=True)

    def of_value(self, text: str, row: int, depth: int = 0) -> CauseLink | None:
        """Return the chain of a value of the program after a scan; None if nothing is known about it.

        Args:
            depth: number of values already followed to reach it.
        """
        raise NotImplementedError

    def of_sequence(self, name: str, row: int) -> CauseLink | None:
        """Return the link of a sequence's wait; None if the sequence has not begun."""
        raise NotImplementedError

    def look(self, looker: Look, row: int) -> None:
        """Run the program up to a scan, and pass the lines of that scan to `looker`."""
        run_again(self.recording, self.spec, self.load, frozenset({row}), row, look=looker)

    def name(self, bits: Bits) -> str:
        """Return the name of an input in the program; without one, its name in the module."""
        for name, address in self.names.addresses.items():
            if address == str(bits.address):
                return name
        if bits.address.bit is None:
            return f"slot{bits.slot} {self.slot(bits.slot).words.inputs[bits.word]}"
        return self.module_name(bits) or str(bits.address)

    def full(self, name: str) -> str:
        """Return the program-wide name for a name in a method."""
        return f"{self.names.prefix}{name.removeprefix('self.')}" if name.startswith("self.") else name

    def place(self, name: str) -> Address:
        """Return the address of an input or output of the program."""
        words = {slot.number: slot.words for slot in self.recording.slots}
        return parse_address(self.names.addresses[name], words)
