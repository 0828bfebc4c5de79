"""The bits of a MOTION_INSTRUCTION, and the codes of its ERR [MOTION-RM002, appendix]."""

from __future__ import annotations

from dataclasses import replace

from ...interpreter import Interpreter
from ...model.operands import Constant, Group
from ...model.predefined.motion_types import MOTION_BITS
from ...model.types import DINT

AXIS_NOT_CONFIGURED = 11


class MotionControl:
    """A MOTION_INSTRUCTION in a scan; its bits lie in FLAGS."""

    def __init__(self, machine: Interpreter, group: Group) -> None:
        self._machine, self._group = machine, group

    def __getitem__(self, name: str) -> bool:
        """Return a bit."""
        place = replace(self._group.member("FLAGS"), bit=Constant(MOTION_BITS[name], DINT))
        return bool(self._machine.get(place))

    def set(self, **bits: bool) -> None:
        """Set bits."""
        for name, value in bits.items():
            place = replace(self._group.member("FLAGS"), bit=Constant(MOTION_BITS[name], DINT))
            self._machine.put(place, value)

    @property
    def ticket(self) -> int:
        """Number of its request to the axis, 0 without one."""
        return int(self._machine.get(self._group.member("~ticket")))

    @ticket.setter
    def ticket(self, value: int) -> None:
        self._machine.put(self._group.member("~ticket"), value)

    def begin(self) -> None:
        """Set the bits of a begun instruction."""
        self.set(EN=True, DN=False, ER=False, IP=False, PC=False, AC=False)
        self._fail(0)
        self.ticket = 0

    def refuse(self, error: int) -> None:
        """Set the bits of a refused or failed instruction, with its ERR."""
        self.set(ER=True, IP=False, AC=False)
        self._fail(error)

    def _fail(self, error: int) -> None:
        self._machine.put(self._group.member("ERR"), error)
