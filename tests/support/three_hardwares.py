"""One list of tests for three hardwares: stories of commands, told to each module that a slot may hold.

A story is a list of steps. After each one the status bits and the position have to be
those given, on all hardwares alike; where one can't do what a step asks, the step
says how it refuses, and there the story ends for it. Bits of inputs are left out:
what shares a terminal differs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from scanrack.io_images import Image
from scanrack.io_images.amci3601 import Configuration, Idle, InputBit, PresetPosition, status_names
from scanrack.io_images.thousands import join_reported
from scanrack.runtime import Amci3601, SlotSpec
from scanrack.runtime.loop.events import JsonValue
from scanrack.runtime.machine import MachineSpec, Switch
from scanrack.runtime.modules.adapters.module import SimulatedAdapter

MS = 1_000_000
A3601, PCL601, PMC006 = "amci3601", "pcl601-adapter", "pmc006-adapter"

HARDWARES: dict[str, dict[str, JsonValue]] = {A3601: {}, PCL601: {}, PMC006: {"home_stroke": 100_000}}
"""The hardwares, with the options without which they do nothing."""

ERRORS = frozenset(
    ("COMMAND_ERROR", "CONFIG_ERROR", "HOME_INVALID", "INPUT_ERROR", "INVALID_PROFILE", "POSITION_INVALID")
)

MOVING = frozenset(("MOVING_CW", "MOVING_CCW"))
SETTLING_MS = 100
"""How long a step takes at least, unless it is shorter; a poll of the slowest line is 50 ms."""

INPUTS = InputBit.HOME | InputBit.ESTOP | InputBit.CW_LIMIT | InputBit.CCW_LIMIT
"""The inputs for which all three have a use."""

CONFIGURATION = Configuration(inputs_used=INPUTS, step_and_direction=True, starting_speed=1000)


@dataclass(frozen=True)
class Refusal:
    """How a hardware says that it can't.

    Attributes:
        bits: its error bits, and no others.
        reason: name of the row of its capabilities.
    """

    bits: set[str]
    reason: str


@dataclass(frozen=True)
class Step:
    """What is done, and what has to be seen some time later.

    Attributes:
        words: what the PLC writes; None leaves the words as they are.
        ms: how long the step lasts; one that expects a standstill is over when it has come.
        bits: status bits at its end, MODULE_OK and the inputs left out.
        position: at its end; a pair is the first and the last one allowed, None any.
        refused: by the name of the hardware.
        inputs: levels to set, by bit.
        running: the PLC's mode, None leaves it.
    """

    words: Image | None
    ms: int
    bits: set[str]
    position: int | tuple[int, int] | None = None
    refused: Mapping[str, Refusal] = field(default_factory=dict)
    inputs: Mapping[InputBit, bool] = field(default_factory=dict)
    running: bool | None = None


START = (
    Step(CONFIGURATION.to_image(), 600, {"MODE_CONFIG"}),
    Step(Image(), 100, {"POSITION_INVALID"}, 0),
    Step(PresetPosition(0).to_image(), 100, set(), 0),
    Step(Image(), 100, set(), 0),
)
"""How most stories begin: configured, in command mode, at a valid position 0."""


class Teller:
    """Tells a story to one hardware.

    Args:
        hardware: its name.
        switches: on its machine.
        options: of that hardware in this story.
    """

    def __init__(
        self, hardware: str, switches: Sequence[Switch], options: Mapping[str, JsonValue] | None = None
    ) -> None:
        given = HARDWARES[hardware] | dict(options or {})
        machine = MachineSpec(switches=tuple(switches))
        self.hardware = hardware
        module = SlotSpec(number=1, module=hardware, options=given, machine=machine).make(seed=0)
        assert isinstance(module, Amci3601 | SimulatedAdapter)
        self.module = module
        self.outputs = Image()
        self.now_ns = 0
        self.image = self.module.update(0, self.outputs)

    def tell(self, steps: Sequence[Step]) -> None:
        """Take the steps, up to the first that is refused."""
        for number, step in enumerate(steps, start=1):
            if step.words is not None:
                self.outputs = step.words
            shaft = self.shaft
            stood = self.bits.isdisjoint(MOVING)
            self._do(step)
            refusal = step.refused.get(self.hardware)
            where = f"step {number} on {self.hardware}"
            if refusal is not None:
                assert self.bits & ERRORS == refusal.bits, where
                assert self.reasons[-1:] == [refusal.reason], where
                assert not stood or self.shaft == shaft, where
                return
            assert self.bits == step.bits | {"MODULE_OK"}, where
            self._check_position(step.position, where)

    def _do(self, step: Step) -> None:
        for bit, energized in step.inputs.items():
            self.module.machine.set_input(bit, energized)
            self.module.look_again()
        if step.running is not None:
            self.module.plc_run(step.running)
        end_ns = self.now_ns + step.ms * MS
        self._run_to(min(end_ns, self.now_ns + SETTLING_MS * MS))
        at_rest = step.bits.isdisjoint(MOVING)
        while self.now_ns < end_ns and not (at_rest and self.bits == step.bits | {"MODULE_OK"}):
            self._run_to(min(end_ns, self.now_ns + SETTLING_MS * MS))

    def _run_to(self, now_ns: int) -> None:
        self.now_ns = now_ns
        self.image = self.module.update(now_ns, self.outputs)

    def _check_position(self, expected: int | tuple[int, int] | None, where: str) -> None:
        if isinstance(expected, tuple):
            assert expected[0] <= self.position <= expected[1], where
        elif expected is not None:
            assert self.position == expected, where

    @property
    def bits(self) -> set[str]:
        """Names of the status bits that are set, inputs left out."""
        names = status_names(self.image[0] & 0xFFFF, self.image[1] & 0xFFFF)
        return {name for name in names if not name.startswith("IN_")}

    @property
    def position(self) -> int:
        """As the image has it."""
        return join_reported(self.image[2], self.image[3])

    @property
    def shaft(self) -> int:
        """Where the machine truly stands."""
        return self.module.machine.shaft

    @property
    def reasons(self) -> list[str]:
        """Names of the refusals so far."""
        return [event.name for event in self.module.events if event.kind == "refusal"]


IDLE = Idle().to_image()
