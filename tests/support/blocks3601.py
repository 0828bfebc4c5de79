"""All function blocks on one axis, in a rack with a simulated 3601, played scan by scan.

bench = BlocksBench.ready()                       # configured, position 0
bench.go("Move", Position=4000).scan()
assert bench.said("Move") == {"Busy", "Active"}

Instances are named after their blocks: Configure, SetPosition, Move, Relative, Velocity, Home, Halt, Stop,
Reset, Gear, Probe, Register, Minimum, Blend, RunBlend. Starting speed 1000, rates 20 up and 10 down unless
told otherwise, as in `bench3601`.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from bench3601 import CONFIGURATION
from drive_bench import ESTOP, HOME, MODELS, LinkedDrive, drive_words
from scanrack import Program
from scanrack.io_images.amci3601 import InputBit, StatusView
from scanrack.ladder.files import parse_program
from scanrack.ladder.files.rungreader import load_library
from scanrack.ladder.lowering.addon import ParameterMode
from scanrack.ladder.model.stubs import NO_STUBS, Stubs
from scanrack.runtime import Amci3601, Card, Cpu, Rack
from scanrack.runtime.loop.exchange import EndOfScan, EveryRpi
from scanrack.runtime.machine import Machine, MachineSpec, Switch
from scanrack.runtime.modules.registry import MODULES
from sequence_bench import NO_WATCHDOG

LIBRARY = load_library("axis3601")

ADAPTER = "amci-drive"

INSTANCES = {
    "Configure": "Configure3601",
    "SetPosition": "MC_SetPosition",
    "Move": "MC_MoveAbsolute",
    "Relative": "MC_MoveRelative",
    "Velocity": "MC_MoveVelocity",
    "Home": "MC_Home",
    "Halt": "MC_Halt",
    "Stop": "MC_Stop",
    "Reset": "MC_Reset",
    "Gear": "MC_GearIn",
    "Probe": "MC_TouchProbe",
    "Register": "MoveRegistration3601",
    "Minimum": "StoreMinimum3601",
    "Blend": "ProgramBlend3601",
    "RunBlend": "RunBlend3601",
}

ARRAYS = {
    "Configuration": "INT[10]",
    "Lengths": "DINT[16]",
    "Velocities": "DINT[16]",
    "Rates": "INT[16]",
}

USUAL = {"Velocity": 5000, "Acceleration": 20, "Deceleration": 10, "Direction": 1}

OUTPUTS = ("Busy", "Active", "Done", "CommandAborted", "Error", "InVelocity", "InGear")

DISABLED, STANDSTILL, DISCRETE, CONTINUOUS, HOMING, STOPPING, ERROR_STOP, SYNCHRONIZED = range(8)


@cache
def program_of(*, told: bool = True, model: str = "") -> Program:
    """Return a program that calls every block once, then the axis.

    Args:
        told: whether it tells the axis of the connection fault.
        model: of the networked drive in slot 1; "" for a 3601.
    """
    tags = ["TAG Axis : AXIS_3601", "TAG Drive : Amci3601", "SLOT module : 1"]
    tags += [f"TAG {name} : {kind}" for name, kind in ARRAYS.items()]
    rungs = ["MOV(module.I.Fault,Drive.Fault);"] if told else []
    for name, block in INSTANCES.items():
        tags.append(f"TAG {name} : {block}")
        operands = [name]
        for each in LIBRARY.add_ons[block.upper()].required:
            if each.mode is ParameterMode.INOUT:
                operands.append(each.name)
            else:
                operands.append(f"{name}_{each.name}")
                tags.append(f"TAG {name}_{each.name} : {each.type.name}")
        rungs.append(f"{block}({','.join(operands)});")
    rungs.append("Amci3601(Drive,Axis,module.I.Data[0],module.O.Data[0]);")
    lines = ["PROGRAM bench", "USE axis3601", *tags, "ROUTINE Main", *rungs, "END", ""]
    stubs = Stubs(modules={1: MODELS[model].words}) if model else NO_STUBS
    program = parse_program("\n".join(lines), stubs=stubs)
    assert isinstance(program, Program)
    return program


SAYING = {
    name: [
        (each.name, f"{name}.{each.name}")
        for each in LIBRARY.add_ons[block.upper()].parameters
        if each.name in OUTPUTS
    ]
    for name, block in INSTANCES.items()
}
"""Outputs of each block, by name and by tag."""


class Diary:
    """Rules that fired, and the output image of every scan.

    Attributes:
        after_scan: called after every scan.
    """

    def __init__(self, rack: Rack) -> None:
        self.fired: list[str] = []
        self.images: list[tuple[int, ...]] = []
        self.after_scan: Callable[[], object] = lambda: None
        self._outputs = rack.slots[1].outputs

    def event(self, scan, now_ns, topic, fields) -> None:
        if topic == "/events" and fields["kind"] == "rule":
            self.fired.append(fields["name"])

    def scan(self, scan, now_ns, flags) -> None:
        self.images.append(tuple(self._outputs))
        self.after_scan()

    def close(self) -> None:
        pass


class BlocksBench:
    """A rack with one 3601 or networked drive, and a program with every block.

    Args:
        model: of the drive; "" for a 3601, `ADAPTER` for one behind the adapter amci-drive.
        inputs: functions of the drive's two inputs.
        firmware: "2.0" to "4.1".
        scan_ms: scan period.
        rpi_ms: period of an asynchronous exchange; None exchanges at the end of the scan.
        machine: switch ranges by input name.
        interpreted: whether the interpreter runs the program.
        told: whether the program tells the axis of the connection fault.
    """

    def __init__(
        self,
        firmware: str = "4.1",
        *,
        scan_ms: int = 2,
        rpi_ms: int | None = None,
        machine: dict[str, tuple[int | None, int | None]] | None = None,
        interpreted: bool = False,
        told: bool = True,
        model: str = "",
        inputs: tuple[int, int] = (HOME, ESTOP),
    ) -> None:
        switches = tuple(
            Switch(InputBit[name.upper()], first, last) for name, (first, last) in (machine or {}).items()
        )
        self.module: Any
        if model == ADAPTER:
            spec, options = MachineSpec(switches=switches), {"in1": "home", "in2": "cw_limit"}
            self.module = MODULES[ADAPTER].make("4.1", spec, 0, options, None)
            self.rack = Rack([Card(1, self.module, ADAPTER)])
        elif model:
            self.module = LinkedDrive(model, Machine(MachineSpec(switches=switches)), inputs)
            self.rack = Rack([Card(1, self.module, model, words=self.module.model.words)])
        else:
            self.module = Amci3601(firmware, Machine(MachineSpec(switches=switches)))
            self.rack = Rack([Card(1, self.module, "amci3601", firmware)])
        program = program_of(told=told, model="" if model == ADAPTER else model)
        self.engine = program.interpret() if interpreted else program.compile()
        self.diary = Diary(self.rack)
        exchange = EndOfScan() if rpi_ms is None else EveryRpi(rpi_ms * 1_000_000)
        self.cpu = Cpu(
            self.rack,
            self.engine,
            scan_ms * 1_000_000,
            exchange=exchange,
            listeners=[self.diary],
            watchdog=NO_WATCHDOG,
        )
        self.tags = self.engine.tags
        self.tags["Axis.RoundTrip"] = 400 if model == ADAPTER else 2 * (rpi_ms or 0) + scan_ms
        self.status = StatusView(self.rack.slots[1].inputs)
        self.is_drive = model not in ("", ADAPTER)

    @classmethod
    def configured(cls, *, config=CONFIGURATION, format: int = 0, **kwargs) -> BlocksBench:
        """Return a bench whose module is configured; the position is not valid."""
        bench = cls(**kwargs)
        if kwargs.get("model", "") not in ("", ADAPTER):
            inputs = kwargs.get("inputs", (HOME, ESTOP))
            config = drive_words(kwargs["model"], inputs=inputs, format=format)
        for number, word in enumerate(config):
            bench.tags[f"Configuration[{number}]"] = (word ^ 0x8000) - 0x8000
        bench.scan()  # prescan takes an Execute that is on at power-up for no edge, as ONS does
        bench.go("Configure").until("Configure", "Done").drop("Configure").scan(2)
        bench.diary.fired.clear()
        return bench

    @classmethod
    def ready(cls, **kwargs) -> BlocksBench:
        """Return a bench at a valid position 0."""
        bench = cls.configured(**kwargs)
        return bench.go("SetPosition").until("SetPosition", "Done").drop("SetPosition").run(30)

    # -- what the user does

    def go(self, name: str, **inputs: int) -> BlocksBench:
        """Set Execute of a block, with these inputs or the usual ones."""
        block = LIBRARY.add_ons[INSTANCES[name].upper()]
        for each in block.required:
            if each.mode is ParameterMode.INPUT and each.name in {**USUAL, **inputs}:
                self.tags[f"{name}_{each.name}"] = {**USUAL, **inputs}[each.name]
        for each in block.parameters:
            if each.mode is ParameterMode.INPUT and not each.required and each.name in inputs:
                self.tags[f"{name}.{each.name}"] = inputs[each.name]
        self.tags[f"{name}_Execute"] = True
        return self

    def drop(self, *names: str) -> BlocksBench:
        """Reset Execute of blocks."""
        for name in names:
            self.tags[f"{name}_Execute"] = False
        return self

    def scan(self, scans: int = 1) -> BlocksBench:
        """Let scans pass."""
        self.cpu.run(scans)
        return self

    def run(self, ms: int) -> BlocksBench:
        """Let time pass."""
        return self.scan(ms * 1_000_000 // self.cpu.period_ns)

    def until(self, name: str, output: str, scans: int = 20_000) -> BlocksBench:
        """Scan until an output of a block is true."""
        tag = f"{name}.{output}"

        def stop_there() -> None:
            if self.tags[tag]:
                self.cpu.stop()

        self.diary.after_scan = stop_there
        self.cpu.run(scans)
        self.diary.after_scan = lambda: None
        if self.tags[tag]:
            return self
        raise AssertionError(f"{name}.{output} never came: {self.said(name)}, state {self.state}")

    # -- what it sees

    def said(self, name: str) -> set[str]:
        """Return the outputs of a block that are true."""
        return {output for output, tag in SAYING[name] if self.tags[tag]}

    @property
    def state(self) -> int:
        """State of the axis."""
        return self.tags["Axis.State"]

    @property
    def position(self) -> int:
        """Position that the module reports."""
        return self.tags["Axis.Position"] if self.is_drive else self.status.position
