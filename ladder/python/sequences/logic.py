"""Logic as a class: inputs, outputs, axes, and sequences that the scan steps.

    input latch | axes judge the inputs | every_scan | sequences, in order | axes write | output latch

The order is the order of definition, base classes first. An instance is the logic of a controller. Before
its first scan, it is attached to the slots. Each first scan (after power-up or program mode) closes the
sequences, resets the parts, and begins the sequences again. Fields of the instance keep their values.

Observers can read, in any scan:

    for sequence in sequences_of(logic):            # in order; always the same objects
        sequence.resumed                            # changes when it, or one of its branches, continues
        sequence.name, sequence.line, sequence.file # where it waits; line is None when it is over
        sequence.waits_for, sequence.since_ns       # "axis.move_to(4000)", and since when
        str(sequence)                               # "cycle, line 14: axis.move_to(4000)"
    fields_of(logic)                                # its fields that are numbers, flags or text, by name

Reading these changes nothing. `resumed` is fast enough to read in every scan; write a row when it changes.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from itertools import chain
from types import CodeType
from typing import Any, ClassVar, Self, TypeVar

from scanrack.io_images.site import sites_of

from .coroutine import Sequence
from .declaring import SequenceMethod, check_class, declarations
from .generated import generated_scan
from .mistakes import check_statements, sources_of
from .parts import Clock, DeclarationError, Device, LogicScan, Part, Slots, Turn
from .signals import Signal, place_of
from .waits import Place

Field = bool | int | float | str
"""Types of recorded fields."""


class Logic:
    """The logic of a rack. Subclass it; an instance is called once per scan.

    The base class has no public name except `every_scan`, so a subclass can use all others.
    """

    _logic_sources: ClassVar[Mapping[str, str]]
    _logic_made: tuple[tuple[Any, ...], dict[str, Any]]
    _logic_clock: Clock
    _logic_slots: Slots | None
    _logic_parts: tuple[Part, ...]
    _logic_sequences: tuple[Sequence, ...]
    _logic_before: tuple[Turn, ...]
    _logic_after: tuple[Turn, ...]
    _logic_codes: tuple[CodeType, ...]  # codes of frames that an online edit has placed
    _logic_forced: dict[str, Field]  # forced fields
    _logic_scan: Callable[[LogicScan], None]
    _places: dict[str, Place]

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        check_class(cls)
        check_statements(cls)
        cls._logic_sources = sources_of(cls)

    def __new__(cls, *args: Any, **options: Any) -> Self:
        """Create an instance with its own parts and sequences; `__init__` need not call the base class."""
        logic = super().__new__(cls)
        logic._logic_made = (args, options)
        logic._logic_clock = Clock()
        logic._logic_slots = None
        logic._logic_before = logic._logic_after = ()
        logic._places = {}
        logic._logic_scan = logic._logic_by_turns
        _declare(logic)
        return logic

    def every_scan(self) -> None:
        """Act in every scan, before the sequences."""

    def __call__(self, scan: LogicScan) -> None:
        """Do one scan."""
        self._logic_scan(scan)

    def _logic_by_turns(self, scan: LogicScan) -> None:
        """Do one scan, part by part, and generate the code for later scans."""
        self._logic_scan_slowly(scan)
        if self._logic_slots is not None:
            self._logic_scan = generated_scan(self, Logic.every_scan)

    def _logic_scan_slowly(self, scan: LogicScan) -> None:
        """Do one scan, part by part."""
        now_ns = self._logic_clock.now_ns = scan.now_ns
        if scan.first or scan.slot is not self._logic_slots:
            self._logic_begin(scan)
            return
        for turn in self._logic_before:
            turn(now_ns)
        self.every_scan()
        for sequence in self._logic_sequences:
            sequence.step(now_ns)
        for turn in self._logic_after:
            turn(now_ns)

    def _logic_begin(self, scan: LogicScan) -> None:
        """Do a first scan: reset the parts, and begin the sequences that don't wait for `restart`."""
        self.__close_logic__()
        if scan.slot is not self._logic_slots:
            self.__attach_logic__(scan.slot)
        for part in self._logic_parts:
            part.reset_part()
        for turn in self._logic_before:
            turn(scan.now_ns)
        self.every_scan()
        for sequence in self._logic_sequences:
            if sequence.starts:
                sequence.begin(scan.now_ns)
            else:
                sequence.step(scan.now_ns)
        for turn in self._logic_after:
            turn(scan.now_ns)

    def __attach_logic__(self, slots: Slots) -> None:
        """Attach the parts to a rack's slots, or raise a ValueError that lists unknown and shared places."""
        errors: list[ValueError] = _undeclared(self)
        for part in self._logic_parts:
            try:
                part.attach(slots, self._logic_clock)
            except ValueError as error:
                errors.append(error)
        errors += _shared(self._logic_parts)
        if errors:
            refused = DeclarationError("\n".join(map(str, errors)), *chain(*map(sites_of, errors)))
            refused.errors = tuple(errors)
            raise refused
        self._logic_slots = slots
        self._logic_take_parts(slots)

    def _logic_take_parts(self, slots: Slots) -> None:
        """Collect the places of the signals and the actions of the devices, in order of definition."""
        self._places = {
            part.name: place_of(part, slots) for part in self._logic_parts if isinstance(part, Signal)
        }
        turns = [part.turns() for part in self._logic_parts if isinstance(part, Device)]
        self._logic_before = tuple(before for before, _ in turns)
        self._logic_after = tuple(after for _, after in turns)
        self._logic_scan = self._logic_by_turns  # an edit changes parts and sequences after this

    def __close_logic__(self) -> None:
        """Close all sequences when the controller ends, then raise any exception from a `finally`."""
        with ExitStack() as stack:
            for sequence in reversed(self._logic_sequences):
                stack.callback(sequence.close)


def _declare(logic: Logic) -> None:
    """Give an instance its own sequences and parts."""
    parts, sequences = [], []
    for name, declaration in declarations(type(logic)).items():
        if isinstance(declaration, SequenceMethod):
            sequence = Sequence(name, declaration.function.__get__(logic), declaration.starts)
            vars(logic)[name] = sequence
            sequences.append(sequence)
            continue
        part = copy.copy(declaration)
        parts.append(part)
        if not hasattr(type(declaration), "__get__"):  # outputs and words are descriptors of the class
            vars(logic)[name] = part
    logic._logic_parts, logic._logic_sequences = tuple(parts), tuple(sequences)


def _undeclared(logic: Logic) -> list[ValueError]:
    """Return an error for each part that an instance creates itself."""
    return [
        DeclarationError.at(
            value.declared, f"{name} is made by an instance; declare it in the body of {type(logic).__name__}"
        )
        for name, value in vars(logic).items()
        if isinstance(value, Part) and not value.loose and value not in logic._logic_parts
    ]


def _shared(parts: tuple[Part, ...]) -> list[ValueError]:
    """Return an error for each pair of parts that would write the same place."""
    owners: list[tuple[Part, tuple[int, int, int]]] = []
    errors: list[ValueError] = []
    for part in parts:
        owned = part.owns()
        if owned is None:
            continue
        for other, other_owned in owners:
            if _overlap(owned, other_owned):
                spot = other.declared.spot
                text = f"{part.name} and {other.name} [{spot}] write the same place in slot {owned[0]}"
                errors.append(DeclarationError.at(part.declared, text))
        owners.append((part, owned))
    return errors


def _overlap(a: tuple[int, int, int], b: tuple[int, int, int]) -> bool:
    """Return whether two places overlap, see `Part.owns`."""
    (a_slot, a_word, a_mask), (b_slot, b_word, b_mask) = a, b
    if a_slot != b_slot:
        return False
    return -1 in (a_word, b_word) or (a_word == b_word and a_mask & b_mask != 0)


def sequences_of(logic: Logic) -> tuple[Sequence, ...]:
    """Return the sequences of an instance, in order of definition; always the same objects."""
    return logic._logic_sequences


def parts_of(logic: Logic) -> tuple[Part, ...]:
    """Return the parts of an instance, in order of definition."""
    return logic._logic_parts


def fields_of(logic: Logic) -> dict[str, Field]:
    """Return an instance's fields that are flags, numbers or text, except names with an underscore."""
    bodies = [name for kind in reversed(type(logic).__mro__) for name in vars(kind)]
    names = dict.fromkeys([*bodies, *vars(logic)])
    values = {
        name: getattr(logic, name) for name in names if not name.startswith("_") and _is_plain(logic, name)
    }
    return {name: value for name, value in values.items() if isinstance(value, Field)}


def _is_plain(logic: Logic, name: str) -> bool:
    """Return whether a name can be read without running user code."""
    return name in vars(logic) or not hasattr(getattr(type(logic), name, None), "__get__")


SomeLogic = TypeVar("SomeLogic", bound=Logic)


def fresh(logic: SomeLogic) -> SomeLogic:
    """Return a new instance made with the same arguments, as after power-up."""
    args, options = logic._logic_made
    return type(logic)(*args, **options)
