"""The bench: a rack with its program and its machine in one's hands, scan by scan.

    line = open_bench("line.toml")           # of scanrack.runtime.cli
    line.run_until(lambda line: line.slot[1].status.MOVE_COMPLETE, within="5 s")
    line.slot[1].press("estop", "100 ms")
    assert line["Trouble"], line.why("Trouble")

Made for tests that read as a story. What does not come about is told with what the bench shows then.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Protocol, Self, runtime_checkable

from ..io_images.amci3601 import StatusView, status_names
from ..io_images.amci3601.bits import InputBit
from ..io_images.image import Image
from .addresses import parse_address
from .build import build_cpu, build_rack
from .cpu import Cpu
from .events import JsonValue
from .incidents import TROUBLES, Happening
from .listener import ScanListener
from .machinetables import INPUT_NAMES
from .quantities import parse_duration
from .rack import Rack, Slot
from .rackspec import RackSpec
from .scan import CpuMode, Logic


class NotReachedError(AssertionError):
    """A condition that did not come about in its time; says what the bench shows instead."""


@runtime_checkable
class Observed(Protocol):
    """Logic that can be looked into: a ladder program under a debugger."""

    stops: tuple[Any, ...]

    @property
    def tags(self) -> Any:
        """The tags by name."""
        ...

    def why(self, tag: str) -> str:
        """Why a tag is as it is."""
        ...

    def force(self, tag: str, value: object) -> None:
        """Hold a tag at a value."""
        ...

    def unforce(self, tag: str | None = None) -> None:
        """Let a tag go."""
        ...


@dataclass(frozen=True, slots=True)
class Told:
    """Something that happened.

    Attributes:
        scan: number of the scan in which it became known.
        now_ns: when, ns since power-up.
        slot: the module, 0 for the CPU.
        kind: "rule", "move", "stimulus", "indicator", or the topic of what the CPU tells.
        name: the rule's id, the move's kind, the input's name; the topic for the CPU.
        text: a sentence.
    """

    scan: int
    now_ns: int
    slot: int
    kind: str
    name: str
    text: str

    def __str__(self) -> str:
        where = f"slot {self.slot}" if self.slot else "CPU"
        return f"scan {self.scan}, {self.now_ns / 1e9:g} s, {where}: {self.text}"


class _Ear:
    """A listener that remembers what is told, and ends a run when it is told to.

    Attributes:
        told: what has happened, oldest first.
        over: asked after every scan whether the run is over.
    """

    def __init__(self) -> None:
        self.told: list[Told] = []
        self.over: Callable[[], object] = bool
        self.cpu: Cpu

    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        slot = fields.get("slot", 0)
        text = fields.get("text", ", ".join(f"{key} {value}" for key, value in fields.items()))
        kind = str(fields.get("kind", topic.strip("/")))
        name = str(fields.get("name", kind))
        self.told.append(Told(scan, now_ns, slot if isinstance(slot, int) else 0, kind, name, str(text)))

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Stop the CPU if the run is over."""
        if self.over():
            self.cpu.stop()

    def close(self) -> None:
        """Nothing is open."""


class SlotBench:
    """A module on the bench, and what it is bolted to.

    Attributes:
        number: its slot.
        outputs: the output image, as the program wrote it last.
        inputs: the input image, as the program saw it last.
        status: the bits and values of the input image by name.
    """

    def __init__(self, bench: Bench, slot: Slot) -> None:
        self.number = slot.number
        self.outputs: Image = slot.outputs
        self.inputs: Image = slot.inputs
        self.status = StatusView(slot.inputs)
        self._bench = bench
        self._module: Any = slot.module
        self._device: Any = getattr(slot.module, "module", slot.module)  # inside of incidents

    @property
    def moving(self) -> bool:
        """Whether the axis moves, either way, as the program saw it last."""
        return self.status.MOVING_CW or self.status.MOVING_CCW

    @property
    def shaft(self) -> int:
        """True position of the shaft, steps from where it stood at power-up; the module may be wrong."""
        return int(self._device.machine.shaft)

    def set_input(self, name: str, energised: bool) -> None:
        """Give an input a level from now on.

        Args:
            name: "capture", "external", "home", "estop", "cw_limit" or "ccw_limit".
            energised: the level.

        Raises:
            ValueError: there is no such input, or the machine of the rack file sees to it.
        """
        bit = INPUT_NAMES.get(name.lower())
        if bit is None:
            raise ValueError(f"there is no input {name!r}: inputs are {', '.join(INPUT_NAMES)}")
        self._device.machine.set_input(bit, energised)
        self._device.look_again()

    def press(self, name: str, for_: str = "50 ms") -> None:
        """Energise an input for a time, during which the bench runs; then let it go.

        Raises:
            ValueError: see `set_input`; or `for_` is no time.
        """
        self.set_input(name, True)
        self._bench.run_for(for_)
        self.set_input(name, False)

    def power_cycle(self) -> None:
        """Remove and restore the module's power."""
        self._module.power_cycle()

    def fail(self, how: str | None) -> None:
        """Let the module stop answering, or answer again (None).

        Args:
            how: "link-lost", "removed", "fatal-error" or "asic-lost".

        Raises:
            ValueError: there is no such trouble, or the module can't be made to fail.
        """
        names = {each.value: trouble for each, trouble in TROUBLES.items()}
        if how is not None and how not in names:
            raise ValueError(f"there is no trouble {how!r}: allowed are {', '.join(names)}")
        if not hasattr(self._device, "inject"):
            raise ValueError(f"slot {self.number}: this module can't be made to fail")
        if how is None and self._device.trouble is TROUBLES[Happening.FATAL_ERROR]:
            self._device.power_cycle()
        else:
            self._device.inject(None if how is None else names[how])

    def __str__(self) -> str:
        msw, lsw = self.inputs[0] & 0xFFFF, self.inputs[1] & 0xFFFF
        bits = " ".join(status_names(msw, lsw)) or "no bit"
        held = [name for name, bit in INPUT_NAMES.items() if self._levels() & bit]
        return (
            f"slot {self.number}: {bits}; position {self.status.position}, shaft {self.shaft}; "
            f"energised {', '.join(held) or 'nothing'}; outputs {list(self.outputs)}"
        )

    def _levels(self) -> InputBit:
        return InputBit(self._device.machine.levels(self._bench.now_ns) & sum(InputBit))


Condition = Callable[["Bench"], Any] | str
"""What a run goes on to: a function of the bench, or a tag that is to be true."""


class Bench:
    """A rack in one's hands.

    Attributes:
        spec: the rack.
        logic: the program.
        cpu: the CPU that runs it.
        slot: the modules by slot number.
        told: what has happened, oldest first.

    Args:
        spec: the rack.
        logic: the program; a ladder program under a debugger for tags, forces and `why`.
        listeners: makes further listeners of the rack, a recorder for one.
    """

    def __init__(
        self,
        spec: RackSpec,
        logic: Logic,
        *,
        listeners: Callable[[Rack], Iterable[ScanListener]] = lambda _rack: (),
    ) -> None:
        self.spec = spec
        self.logic: Any = logic
        self._observed = isinstance(logic, Observed)
        rack = build_rack(spec)
        self._ear = ear = _Ear()
        self.told = ear.told
        self.cpu = ear.cpu = build_cpu(spec, logic, rack, listeners=[*listeners(rack), ear])
        self.slot = {number: SlotBench(self, slot) for number, slot in rack.slots.items()}

    # --- time

    @property
    def scans(self) -> int:
        """Number of scans so far."""
        return self.cpu.scan

    @property
    def now_ns(self) -> int:
        """Virtual time of the latest scan, ns since power-up; 0 before the first."""
        return max(self.cpu.now_ns - self.cpu.period_ns, 0)

    @property
    def now_s(self) -> float:
        """Virtual time of the latest scan, s since power-up."""
        return self.now_ns / 1e9

    @property
    def stops(self) -> tuple[Any, ...]:
        """The breakpoints that were met in the latest scan."""
        return self.logic.stops if self._observed else ()

    def scan(self, scans: int = 1) -> None:
        """Run scans; a breakpoint that is met ends the run.

        Raises:
            CpuFault: the program faults the CPU.
        """
        self._run(scans, lambda: self.stops)

    def _run(self, scans: int, over: Callable[[], object]) -> None:
        self._ear.over = over
        try:
            self.cpu.run(scans)
        finally:
            self._ear.over = bool

    def run_for(self, time: str) -> None:
        """Run for a machine time with its unit, such as "2 s", rounded up to whole scans.

        Raises:
            ValueError: this is no time.
            CpuFault: the program faults the CPU.
        """
        self.scan(-(-parse_duration(time) // self.cpu.period_ns))

    def run_until(self, condition: Condition, within: str = "10 s") -> None:
        """Run until a condition holds, which it may do already.

        Args:
            condition: a function of the bench, or the address of a tag that is to be true.
            within: longest machine time.

        Raises:
            NotReachedError: it does not come about in time; what the bench shows then.
            ValueError: `within` is no time, or there is no such tag.
            CpuFault: the program faults the CPU.
        """
        scans = -(-parse_duration(within) // self.cpu.period_ns)
        if not self._holds(condition):
            self._run(scans, lambda: self.stops or self._holds(condition))
        if not self.stops and not self._holds(condition):
            wanted = condition if isinstance(condition, str) else _name(condition)
            raise NotReachedError(f"{wanted} has not come about within {within}.\n{self}")

    def _holds(self, condition: Condition) -> bool:
        return bool(self[condition] if isinstance(condition, str) else condition(self))

    def program_mode(self) -> None:
        """Turn the CPU's key to program: logic rests, outputs are not sent."""
        self.cpu.mode = CpuMode.PROGRAM

    def run_mode(self) -> None:
        """Turn the CPU's key to run."""
        self.cpu.mode = CpuMode.RUN

    # --- the program

    @property
    def program(self) -> Any:
        """The ladder program under its debugger: breakpoints, truth, pictures, cross reference.

        Raises:
            ValueError: the program is a Python function.
        """
        if not self._observed:
            raise ValueError("the program is a Python function: it has no tags and no rungs")
        return self.logic

    def __getitem__(self, tag: str) -> Any:
        return self.program.tags[tag]

    def __setitem__(self, tag: str, value: object) -> None:
        self.program.tags[tag] = value

    def why(self, tag: str) -> str:
        """Say why a tag is as it is, see `Debugger.why`."""
        return str(self.program.why(tag))

    def force(self, address: str, value: int) -> None:
        """Hold a bit or word of an image, or a tag, at a value; forces of images are recorded.

        Raises:
            ValueError: there is nothing of that name, or the value does not fit.
        """
        if self._is_image(address):
            self.cpu.forces.set(address, value)
        else:
            self.program.force(address, value)

    def unforce(self, address: str) -> None:
        """Let go of what is forced.

        Raises:
            ValueError: it is not forced.
        """
        if self._is_image(address):
            self.cpu.forces.remove(address)
        else:
            self.program.unforce(address)

    def _is_image(self, address: str) -> bool:
        try:
            parse_address(address, {slot.number: slot.module for slot in self.spec.slot})
        except ValueError:
            return False
        return True

    # --- what happened

    @property
    def rules(self) -> Sequence[str]:
        """Ids of the manual's rules that have fired, in their order."""
        return [each.name for each in self.told if each.kind == "rule"]

    def __str__(self) -> str:
        lines = [f"scan {self.scans}, {self.now_s:g} s", *map(str, self.slot.values())]
        lines += [f"  {each}" for each in self.told[-5:]]
        return "\n".join(lines)

    # --- the end

    def close(self) -> None:
        """Close all listeners; a recording is whole then."""
        self.cpu.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _name(condition: Callable[..., Any]) -> str:
    name = str(getattr(condition, "__name__", "the condition"))
    return "the condition" if name == "<lambda>" else name
