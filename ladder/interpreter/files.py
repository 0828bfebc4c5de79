"""Operands of instructions as objects: structures, and arrays starting at an element."""

from __future__ import annotations

from ..model.operand_checks import array_of
from ..model.operands import Group, Resolved
from ..model.types import DataType, count_of
from ..state.memory import Value
from .place_values import PlaceValues


class Members:
    """A structure in a scan: `alarm["Acked"]`, `alarm.set(Acked=True)`."""

    def __init__(self, machine: PlaceValues, group: Group) -> None:
        self._machine, self._group = machine, group

    def __getitem__(self, name: str) -> Value:
        """Return a member."""
        return self._machine.get(self._group.member(name))

    def set(self, **members: Value) -> None:
        """Set members, without flags and faults."""
        for name, value in members.items():
            place = self._group.member(name)
            self._machine.put(place, self._machine.converted(place.type, value))


class Control(Members):
    """A CONTROL in a scan."""

    def __getitem__(self, name: str) -> int:
        """Return a member; a bit is 0 or 1."""
        return self._machine.whole(super().__getitem__(name))

    def check(self) -> None:
        """Fault if LEN or POS is negative."""
        length, position = self["LEN"], self["POS"]
        if length < 0 or position < 0:
            machine = self._machine
            machine.fault_log.negative_control(machine.site, self._group.text, length, position)


class Elements:
    """Elements of an array, starting at the operand, along one or all dimensions; a bad index faults."""

    def __init__(self, machine: PlaceValues, operand: Resolved, dimension: int | None = None) -> None:
        """Find the elements that start at the operand: all elements, or the elements along one dimension."""
        self._machine = machine
        self._store, self._region, self._first = machine.end(operand)
        self.type: DataType = self._region.type
        self._stride, self._length = 1, self._region.left(self._first, self._store)
        dims = array_of(operand)
        if dimension is not None and len(dims) > 1:
            self._stride = count_of(dims[dimension + 1 :])
            position = self._first % count_of(dims) // self._stride % dims[dimension]
            self._length = dims[dimension] - position

    def __len__(self) -> int:
        """Return the number of elements."""
        return self._length

    def _index(self, number: int) -> int:
        if not 0 <= number < self._length:
            machine = self._machine
            machine.fault_log.subscript(machine.site, self._region.text, number, self._length)
        return self._first + number * self._stride

    def __getitem__(self, number: int) -> Value:
        """Return an element of an elementary type."""
        return self._store.read(self._region.parts[0].leaf, self._index(number))

    def __setitem__(self, number: int, value: Value) -> None:
        """Set an element to a value of its type."""
        self._store.write(self._region.parts[0].leaf, self._index(number), value)

    def take(self, number: int, count: int = 1) -> bytes:
        """Return elements of any type as bytes."""
        return self._machine.take_bytes(self._store, self._region, self._index(number), count)

    def put(self, number: int, data: bytes, count: int = 1) -> None:
        """Set elements of any type from bytes."""
        self._machine.put_bytes(self._store, self._region, self._index(number), count, data)
