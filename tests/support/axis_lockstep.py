"""The same script on the function blocks of rungs and on the axis in Python, each with a module of its own.

A script is a list of deeds, each with the scans until the next one. A command is a rising Execute for one
scan, or a call of the axis's method in that scan.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from bench3601 import ENCODER, configuration
from blocks3601 import BlocksBench
from drive_bench import MODELS, LinkedDrive, drive_words
from scanrack import Axis3601, Configuration, Direction, Logic
from scanrack.io_images.amci3601 import Acceleration, BlendSegment, InputBit
from scanrack.io_images.image import Image
from scanrack.io_images.module_words import PLAIN_WORDS
from scanrack.jobs.fuzz.invariants.busy import RestMeter, axes_in
from scanrack.ladder.python.axis3601.drive import Drive
from scanrack.runtime import Amci3601, Card, Cpu, ModuleFault, Rack
from scanrack.runtime.loop.exchange import EndOfScan, EveryRpi
from scanrack.runtime.machine import Machine, MachineSpec, Switch

RATES = {"acceleration": 20, "deceleration": 10}
BLOCK_RATES = {"Acceleration": 20, "Deceleration": 10}

SEGMENTS = ((3_000, 5_000, 20), (2_200, 2_000, 10))

SWITCHES = {"home": (300, 500), "cw_limit": (9_000, None), "ccw_limit": (None, -9_000)}
WORDS = configuration(add=ENCODER)


@dataclass(frozen=True)
class Ask:
    """One command: the block with its inputs, and the method with its arguments."""

    block: str
    inputs: dict[str, int]
    method: str
    arguments: tuple[Any, ...]
    options: dict[str, Any]


def _move(block: str, given: str, method: str, amount: int, speed: int = 5_000, shape: int = 0) -> Ask:
    inputs = {given: amount, "Velocity": speed, "Shape": shape, **BLOCK_RATES}
    options = {"speed": speed, **RATES, "shape": Acceleration(shape)}
    return Ask(block, inputs, method, (amount,), options)


def _run(speed: int, register: int | None = None) -> Ask:
    inputs = {"Velocity": speed, "Shape": 0, **BLOCK_RATES}
    if register is None:
        return Ask("Velocity", inputs, "run", (speed,), RATES)
    inputs |= {"Distance": register, "Register": 0}
    return Ask("Register", inputs, "run", (speed,), {**RATES, "register": register})


def _home(way: Direction) -> Ask:
    """A search for home; a side that is near lets its proximity be true."""
    inputs = {"Direction": way.value, "Velocity": 2_000, **BLOCK_RATES}
    return Ask("Home", inputs, "home", (way,), {"speed": 2_000, **RATES})


ASKS = {
    "configure": Ask("Configure", {}, "configure", (), {}),
    "preset": Ask("SetPosition", {"Position": -1_234}, "set_position", (-1_234,), {}),
    "to 2000": _move("Move", "Position", "move_to", 2_000),
    "to -3500": _move("Move", "Position", "move_to", -3_500, 2_500, 3),
    "too slow": _move("Move", "Position", "move_to", 100, 5),  # below the starting speed: the module refuses
    "too fast": _move("Move", "Position", "move_to", 100, 1_000_001),
    "by -700": _move("Relative", "Distance", "move_by", -700, 3_000, 1),
    "by 5": _move("Relative", "Distance", "move_by", 5),
    "run 3000": _run(3_000),
    "run 1500": _run(1_500),
    "run -2000": _run(-2_000),
    "register": _run(2_500, 1_500),
    "home cw": _home(Direction.CW),
    "home ccw": _home(Direction.CCW),
    "gear": Ask(
        "Gear",
        {"RatioNumerator": -3, "RatioDenominator": 2, "Acceleration": 0, "Deceleration": 0},
        "gear",
        (-3, 2),
        {},
    ),
    "halt": Ask("Halt", {}, "halt", (), {}),
    "reset": Ask("Reset", {}, "reset", (), {}),
    "minimum": Ask("Minimum", {"Distance": 400}, "store_minimum", (400,), {}),
    "run blend": Ask("RunBlend", {"Direction": 1}, "run_blend", (Direction.CW,), {}),
    "run blend back": Ask("RunBlend", {"Direction": -1}, "run_blend", (Direction.CCW,), {}),
}

BLEND = Ask(
    "Blend",
    {"Segments": 2, "FinalDeceleration": 10, "FinalShape": 1},
    "program_blend",
    ([BlendSegment(*each) for each in SEGMENTS],),
    {"final_deceleration": 10, "final_shape": Acceleration.TRIANGULAR},
)

STOP = Ask("Stop", {}, "stop", (), {})

OTHERS = (
    "stop",
    "stop off",
    "near",
    "far",
    "register on",
    "estop on",
    "estop off",
    "power",
    *("lost", "found") * 3,
    "turn encoder",
)
"""Deeds that are no commands."""


class LateAxis(Axis3601):
    """An axis that judges the inputs after the logic, as rungs do."""

    def _new_drive(self, slot_ms: int = 0) -> Drive:
        trip_ns = max(self.round_trip_ms, slot_ms) * 1_000_000
        return Drive(trip_ns, parameters_first=self.parameters_first, late=True)


def machine() -> Machine:
    """Return the machine of both sides."""
    switches = tuple(Switch(InputBit[name.upper()], *ends) for name, ends in SWITCHES.items())
    return Machine(MachineSpec(switches=switches))


class Lawful:
    """A side on which no command is busy while the axis rests for a second and the link is good."""

    module: Amci3601 | LinkedDrive
    cpu: Cpu
    rests: RestMeter

    def check_the_law(self) -> None:
        """Check it at the end of a scan."""
        assert self.rests.update(self.cpu.now_ns, linked=self.module.linked) is None


class PythonSide(Lawful):
    """A rack with one 3601 or networked drive, and an axis in Python that does the deed of the scan."""

    def __init__(
        self,
        *,
        late: bool,
        scan_ms: int = 2,
        rpi_ms: int | None = None,
        model: str = "",
        format: int = 0,
        **options: Any,
    ) -> None:
        kind = LateAxis if late else Axis3601
        setup: Any = drive_words(model, format=format) if model else Configuration.from_image(Image(WORDS))
        side = self

        class Script(Logic):
            axis = kind(1, setup, round_trip_ms=2 * (rpi_ms or 0) + scan_ms, **options)

            def every_scan(self) -> None:
                side.do(self.axis)

        self.module = LinkedDrive(model, machine()) if model else Amci3601("4.1", machine())
        words = MODELS[model].words if model else PLAIN_WORDS
        self.rack = Rack([Card(1, self.module, words=words)])
        self.logic = Script()
        exchange = EndOfScan() if rpi_ms is None else EveryRpi(rpi_ms * 1_000_000)
        self.cpu = Cpu(self.rack, self.logic, scan_ms * 1_000_000, exchange=exchange)
        self.rests = RestMeter(axes_in(self.logic, {}))
        self.deed: str | None = None
        self.last: dict[str, Any] = {}
        self.near = False

    def do(self, axis: Axis3601) -> None:
        deed, self.deed = self.deed, None
        ask = ask_of(deed)
        if deed in ("near", "far"):
            self.near = deed == "near"
        if ask is not None:
            more = {"proximity": lambda: self.near} if ask.method == "home" else {}
            command = getattr(axis, ask.method)(*ask.arguments, **ask.options, **more)
            self.last[ask.block] = command
            if deed == "stop":
                command.__enter__()
        elif deed == "stop off" and "Stop" in self.last:
            self.last["Stop"].__exit__(None, None, None)
        elif deed == "register on" and "Register" in self.last:
            self.last["Register"].register()

    def scan(self, deed: str | None) -> list[int]:
        self.deed = deed
        happen(self.module, self.cpu, deed)
        self.cpu.run(1)
        self.check_the_law()
        return list(self.rack.slots[1].outputs)

    def outcome(self, block: str) -> tuple[str, int]:
        command = self.last.get(block)
        return ("none", 0) if command is None else (command.outcome.value, int(command.error_id))


class RungSide(Lawful):
    """The bench of the function blocks, with the same deeds."""

    def __init__(
        self,
        *,
        scan_ms: int = 2,
        rpi_ms: int | None = None,
        model: str = "",
        format: int = 0,
        interpreted: bool = False,
    ) -> None:
        self.bench = BlocksBench(
            scan_ms=scan_ms, rpi_ms=rpi_ms, machine=SWITCHES, model=model, interpreted=interpreted
        )
        self.module, self.cpu = self.bench.module, self.bench.cpu
        self.rests = RestMeter(axes_in(self.bench.engine, self.bench.tags))
        for number, word in enumerate(drive_words(model, format=format) if model else WORDS):
            self.bench.tags[f"Configuration[{number}]"] = (word ^ 0x8000) - 0x8000
        for number, values in enumerate(SEGMENTS):
            for name, value in zip(("Lengths", "Velocities", "Rates"), values, strict=True):
                self.bench.tags[f"{name}[{number}]"] = value
        self._on: list[str] = []
        self.results: dict[str, tuple[str, int]] = {}

    def scan(self, deed: str | None) -> list[int]:
        for name in self._on:
            self.bench.drop(name)
        self._on = []
        ask = ask_of(deed)
        if ask is not None:
            self.bench.go(ask.block, **ask.inputs)
            self.results[ask.block] = ("busy", 0)
            if deed != "stop":
                self._on.append(ask.block)
        elif deed == "stop off":
            self.bench.drop("Stop")
        elif deed in ("near", "far"):
            self.bench.tags["Home.Proximity"] = deed == "near"
        elif deed == "register on":
            self.bench.tags["Register.Register"] = True
        happen(self.module, self.bench.cpu, deed)
        self.bench.scan()
        self.check_the_law()
        self._note()
        return list(self.bench.rack.slots[1].outputs)

    def _note(self) -> None:
        words = {"Done": "done", "CommandAborted": "aborted", "Error": "error"}
        for block, (result, _) in self.results.items():
            for output, word in words.items():
                if result == "busy" and self.bench.tags[f"{block}.{output}"]:
                    self.results[block] = (word, self.bench.tags[f"{block}.ErrorID"])

    def outcome(self, block: str) -> tuple[str, int]:
        return self.results.get(block, ("none", 0))


def legal(script: Iterable[tuple[str, int]]) -> Iterator[tuple[int, str]]:
    """Yield the scan and the deed of each entry, less those that mean something else to rungs.

    An Execute that stays on is not an edge: the same block in the scan before, a stop that is held. Whether a
    stop that is held refuses Configure3601 on a lost module depends on the order of the rungs.
    """
    scan, held, before = 0, False, (-1, "")
    for deed, pause in script:
        ask = ask_of(deed)
        block = ask.block if ask else ""
        if not (block and before == (scan - 1, block)) and not (held and deed in ("stop", "configure")):
            yield scan, deed
            before = (scan, block)
            held = deed == "stop" or (held and deed != "stop off")
        scan += pause


def ask_of(deed: str | None) -> Ask | None:
    """Return the command of a deed."""
    return {"blend": BLEND, "stop": STOP, **ASKS}.get(deed or "")


def happen(module: Amci3601 | LinkedDrive, cpu: Cpu, deed: str | None) -> None:
    """Do what is not a command: to the machine, the module, the link."""
    if deed in ("estop on", "estop off"):
        module.machine.set_input(InputBit.ESTOP, deed == "estop on")
        module.look_again()
    elif deed == "power":
        module.power_cycle()
    elif deed == "lost":
        module.inject(ModuleFault.LINK_LOST)
    elif deed == "found":
        module.inject(None)
    elif deed == "turn encoder":
        now = cpu.now_ns
        with suppress(ValueError):  # the turn before is not over
            module.machine.turn_encoder(200, now, now + 100_000_000)
        module.look_again()


READY = (("", 1), ("configure", 40), ("preset", 40))
"""The first deeds of a script; an Execute in the first scan is not an edge."""
