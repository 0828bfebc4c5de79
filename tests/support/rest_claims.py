"""Random sequences of an adapter: motions, their ends, faults of the line, and pulses of one to five scans.

`violations(seed)` plays one sequence and returns what was false of it, as sentences:

* an image claims rest (STOPPED, MOVE_COMPLETE, AT_HOME, HOLD_STATE) while the simulated motor turns, or
  without a link;
* a command edge, given in run mode while the image shows MODULE_OK, has neither an effect nor a bit.

The motor is asked itself. An edge is followed into the command layer, where a set bit, another operation or
another position counts as its effect.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from random import Random
from typing import Any

from adapterbench import BENCHES, CONFIGURE, CONFIGURE_006
from late_replies import LateDevice
from scanrack.io_images import Image
from scanrack.io_images.amci3601 import CommandMsw, InputBit, StatusMsw
from scanrack.io_images.thousands import split_thousands
from scanrack.runtime.loop.incidents import FaultKind
from scanrack.runtime.machine import Switch

REST = (
    StatusMsw.STOPPED | StatusMsw.MOVE_COMPLETE | StatusMsw.AT_HOME | StatusMsw.HOLD_STATE
).value  # bits that claim rest
MOVING = {"MOVING_CW", "MOVING_CCW"}
MODULE_OK, MODE_CONFIG = StatusMsw.MODULE_OK.value, StatusMsw.MODE_CONFIG.value
REFUSED = (
    StatusMsw.COMMAND_ERROR | StatusMsw.INVALID_PROFILE | StatusMsw.HOME_INVALID | StatusMsw.INPUT_ERROR
).value
"""Bits of a refused command; an active emergency stop or limit refuses with INPUT_ERROR."""
BITS = 0x7FFF
STOP, HOLD, RESET = CommandMsw.IMMEDIATE_STOP.value, CommandMsw.HOLD_MOVE.value, CommandMsw.RESET_ERRORS.value
HARMLESS = STOP | HOLD | RESET
"""Commands that may have nothing to do: nothing moves, or slows down already, and there is no error."""

HOME = Switch(InputBit.HOME, -3000, -2500)
LIMITS = (Switch(InputBit.CCW_LIMIT, None, -9000), Switch(InputBit.CW_LIMIT, 14_000, None))
OPTIONS: dict[str, dict[str, Any]] = {
    "PCL601": {"blend": "segmented", "respeed": "restart"},
    "drive": {"in2": "estop", "unwired": "inactive"},
    "PMC006": {"hold": "immediate", "registration": "polled", "blend": "segmented", "respeed": "restart"},
}
Words = tuple[int, ...]
NOTHING: Words = (0,) * 8
LONG_MS = 1500
"""Longer than an adapter takes to believe that the motor rests."""

ENDLESS_MS = 5000
"""Longer than a motion with an end takes."""

REFUSED_BY_ADAPTER = ("locked out", "missed")


def _rates(random: Random) -> Words:
    rate = random.choice((20, 100, 500))
    return (random.choice((1, 2, 5, 8)), 0, rate, rate)


def motion_words(random: Random) -> Words:
    """Return the words of a motion."""
    steps = random.choice((7, 60, 400, 1500, 6000)) * random.choice((1, 1, -1))
    far, rates = split_thousands(steps), _rates(random)
    return random.choice(
        [
            (CommandMsw.RELATIVE_MOVE.value, 0, *far, *rates),
            (CommandMsw.RELATIVE_MOVE.value, 0, *far, *rates),
            (CommandMsw.ABSOLUTE_MOVE.value, 0, *far, *rates),
            (CommandMsw.MANUAL_CW.value, 0, 0, 0, *rates),
            (CommandMsw.MANUAL_CCW.value, 0, 0, 0, *rates),
            (CommandMsw.MANUAL_CW.value, 0, 2, 0, *rates),  # a registration move
            (CommandMsw.MANUAL_CW.value, 0, 0, 0, 0, 0, 0, 0),  # a single step
            (CommandMsw.FIND_HOME_CCW.value, 0, 0, 0, *rates),
            (CommandMsw.FIND_HOME_CW.value, 0, 0, 0, *rates),
            (CommandMsw.RUN_BLEND_CW.value,),
        ]
    )


def pulse_words(random: Random) -> Words:
    """Return the words of a command that may come at any moment."""
    if random.random() < 0.3:
        return motion_words(random)
    return random.choice(
        [
            (STOP,),
            (HOLD,),
            (CommandMsw.RESUME_MOVE.value, 0, 0, 0, *_rates(random)),
            (RESET,),
            (CommandMsw.PRESET_POSITION.value, 0, *split_thousands(random.randint(-5000, 5000))),
            (CommandMsw.PRESET_POSITION.value,),
            (CommandMsw.RELATIVE_MOVE.value, 0, 0, 40, 2, 0, 100, 100),
            (CommandMsw.PRESET_ENCODER.value,),
        ]
    )


BLEND = [(0, 0x300, 2, 0, 0, 20), (0, 0x300, 1, 0, 3, 0, 20), (0, 0x300, 1, 500, 5, 0, 20)]
"""The blocks of a stored blend profile: 1,000 and 1,500 steps."""

INTERRUPTIONS = (
    "stop", "stop", "stop", "program", "estop", "estop", "limit", "hold", "release", "configure", "configure",
    "external", "nothing",
)  # fmt: skip
FAULTS = ("none", "drop", "corrupt", "late", "down", "controller power")


@dataclass
class Edge:
    """A command bit that has risen in the words."""

    bit: int
    scan: int


@dataclass
class Sequence:
    """A sequence while it is played.

    Attributes:
        given: edges that the command layer has not got yet.
        counts: what has been played, by name.
    """

    seed: int
    controller: str = ""
    random: Random = field(init=False)
    wrong: list[str] = field(default_factory=list)
    given: list[Edge] = field(default_factory=list)
    counts: Counter[str] = field(default_factory=Counter)
    scans: int = 0
    pending: list[tuple[int, str, Any]] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Choose a controller, and listen to its command layer."""
        self.random = Random(self.seed)
        self.controller = self.controller or self.random.choice(("PCL601", "PMC006"))
        make = BENCHES[self.controller]
        self.scan_ms = self.random.choice((1, 2, 2, 5, 10))
        self.has_limits = self.random.random() < 0.5
        switches = (HOME, *(LIMITS if self.has_limits else ()))
        options = dict(OPTIONS[self.controller])
        self.configuration = CONFIGURE_006
        if self.controller == "PCL601":
            options["registration"] = self.random.choice(("default", "jumper", "polled"))
            self.configuration = self.random.choice((CONFIGURE, CONFIGURE_006))
        self.bench = make(*switches, scan_ms=self.scan_ms, **options)
        self.bench.configured(*self.configuration)
        if self.random.random() < 0.3:
            for block in BLEND:
                self.bench.give(*block, ms=20).give(0, 0x100, ms=20)
            self.bench.release(20)
        faults = self.bench.module.controller.line.faults
        faults.device = self.late = LateDevice(faults.device)
        self.words, self.running = NOTHING, True
        self.motor, self.claimed = self.bench.motor, False
        self.presets = 0
        self.listen()
        self.bench.module.events.clear()

    # ---- the command layer

    def listen(self) -> None:
        """Note each edge that the command layer gets, and what comes of it."""
        layer: Any = self.bench.module.layer
        if getattr(layer, "listened", False):
            return
        layer.listened = True
        command, preset = layer._command, layer.axis.preset_position

        def presets(value: int) -> None:
            self.presets += 1
            preset(value)

        def commanded(now_ns: int, words: Any, edges: int) -> None:
            before = (layer.state.latches.bits, layer.operation, self.presets, layer.axis.encoder)
            command(now_ns, words, edges)
            after = (layer.state.latches.bits, layer.operation, self.presets, layer.axis.encoder)
            if before == after and not after[0] & REFUSED and not words.msw & HARMLESS:
                self.wrong.append(f"scan {self.scans}: {words.msw:#06x} has neither an effect nor a bit")
            self.got(edges)

        layer._command = commanded
        layer.axis.preset_position = presets

    def got(self, edges: int) -> None:
        """Take the edges that the layer has got from those given."""
        for at in range(15):
            if edges >> at & 1:
                match = next((each for each in self.given if each.bit == 1 << at), None)
                if match is not None:
                    self.given.remove(match)

    # ---- scans

    def scan(self) -> None:
        """Play one scan, and look at it."""
        bench, module = self.bench, self.bench.module
        for due, name, value in [each for each in self.pending if each[0] <= self.scans]:
            self.pending.remove((due, name, value))
            self.happen(name, value)
        bench.outputs = Image(self.words)
        bench.now_ns += bench.scan_ns
        bench.image = module.update(bench.now_ns, bench.outputs)
        self.scans += 1
        self.listen()
        self.look(bench.image[0] & 0xFFFF)

    def look(self, msw: int) -> None:
        """Compare an image with the motor."""
        bench = self.bench
        linked, claims = bool(msw & MODULE_OK), bool(msw & REST) and not msw & MODE_CONFIG
        turns, moved = bench.device.motor_turns, bench.motor != self.motor
        names = sorted(bench.bits)
        whole = any(event.kind == "move" for event in bench.module.events)  # a motion within one scan
        if claims and turns:
            self.wrong.append(f"scan {self.scans}: {names} while the motor turns")
        elif claims and self.claimed and moved and not whole:
            self.wrong.append(f"scan {self.scans}: {names}, and the motor has moved since the scan before")
        elif claims and not linked:
            self.wrong.append(f"scan {self.scans}: {names} without a link")
        self.counts["scans that claim rest" if claims else "scans without a claim"] += 1
        self.motor, self.claimed = bench.motor, claims
        refused = sum(event.name in REFUSED_BY_ADAPTER for event in bench.module.events)
        bench.module.events.clear()
        if refused or not linked or msw & StatusMsw.CONFIG_ERROR.value:
            self.given.clear()  # a bit shows that commands do not count

    def put(self, words: Words) -> None:
        """Write words; note the edges that have to count."""
        words = (*words, *NOTHING)[:8]
        signed = (words[0] - 0x10000 if words[0] > 0x7FFF else words[0], *words[1:])
        shown = self.bench.image[0] & 0xFFFF
        before = self.bench.outputs[0]  # the words of the scan before
        risen = signed[0] & ~before & BITS if signed[0] >= 0 else 0
        if self.running and shown & MODULE_OK and not shown & MODE_CONFIG:
            for at in range(15):
                if risen >> at & 1:
                    self.given.append(Edge(1 << at, self.scans))
                    self.counts["edges"] += 1
        self.words = signed

    def run(self, ms: float) -> None:
        """Let time run."""
        for _ in range(max(1, round(ms / self.scan_ms))):
            self.scan()

    def later(self, ms: float, name: str, value: Any = None) -> None:
        """Let something happen in so many ms."""
        self.pending.append((self.scans + round(ms / self.scan_ms), name, value))

    # ---- what happens

    def happen(self, name: str, value: Any) -> None:
        """Let something happen from outside."""
        module = self.bench.module
        faults = module.controller.line.faults
        if name == "plc":
            self.running = value
            module.plc_run(value)
            if not value:
                self.given.clear()  # outputs count as zero
        elif name == "input":
            self.bench.level(*value)
        elif name == "drop":
            faults.drop_next += value
        elif name == "corrupt":
            faults.corrupt_next += value
        elif name == "late":
            self.late.delay({self.random.randint(0, 12): value for _ in range(3)})
        elif name == "down":
            module.disturb(FaultKind.LINE_DOWN, begins=value, lasts=True)
        else:
            module.cycle_device()

    def fault(self) -> None:
        """Let something happen to the line around now."""
        random = self.random
        kind = random.choices(FAULTS, (6, 5, 5, 3, 5, 1))[0]
        self.counts[f"fault: {kind}"] += 1
        at = random.randint(0, 120)
        if kind in ("drop", "corrupt"):
            self.later(at, kind, random.randint(1, 4))
        elif kind == "late":
            self.later(at, kind, random.randint(60, 900))
        elif kind == "down":
            self.later(at, kind, True)
            self.later(at + random.choice((5, 30, 80, 150, 400, 1200)), kind, False)
        elif kind == "controller power":
            self.later(at, kind)

    def interrupt(self, kind: str) -> None:
        """End the motion in one way."""
        random = self.random
        self.counts[f"end: {kind}"] += 1
        if kind == "stop":
            self.pulse((STOP,))
        elif kind == "hold":
            self.pulse((HOLD,))
        elif kind == "program":
            self.later(0, "plc", False)
            self.run(random.choice((2, 10, 40, 300)))
            self.later(0, "plc", True)
        elif kind in ("estop", "limit"):
            bit = (
                InputBit.ESTOP if kind == "estop" else random.choice((InputBit.CW_LIMIT, InputBit.CCW_LIMIT))
            )
            if kind == "estop" or not self.has_limits:
                self.later(0, "input", (bit, True))
                self.later(random.choice((5, 25, 60, 200, 500)), "input", (bit, False))
        elif kind == "external":
            if self.configuration == CONFIGURE:
                self.later(0, "input", (InputBit.EXTERNAL, True))
                self.later(random.choice((25, 60, 500)), "input", (InputBit.EXTERNAL, False))
        elif kind == "release":
            self.put(NOTHING)
        elif kind == "configure":
            self.put(self.configuration)
            self.run(random.choice((2, 20, 100, 400)))
            self.put(NOTHING)

    def pulse(self, words: Words) -> None:
        """Set a command for one to five scans."""
        self.put(words)
        for _ in range(self.random.randint(1, 5)):
            self.scan()
        self.put(NOTHING)
        self.scan()

    def episode(self) -> None:
        """One motion, its end, and pulses."""
        random = self.random
        words = motion_words(random)
        if random.random() < 0.4:
            self.pulse(words)
        else:
            self.put(words)
        self.run(random.choice((0, 10, 25, 50, 150, 500)))
        self.fault()
        if random.random() < 0.5:
            self.run(random.randint(0, 100))
        self.interrupt(random.choice(INTERRUPTIONS))
        for _ in range(random.randint(0, 4)):
            self.run(random.choice((0, 0, 0, 4, 10, 20, 30, 80, 250)))
            if random.random() < 0.3:
                self.fault()
            if self.words != NOTHING and random.random() < 0.5:
                self.put(NOTHING)
                self.scan()
            self.pulse(pulse_words(random))
        if random.random() < 0.5:
            self.settle()

    def settle(self) -> None:
        """Let everything come to its end; no edge may be left."""
        self.put(NOTHING)
        rested = turned = 0
        while rested * self.scan_ms < LONG_MS:
            self.scan()
            turns = self.bench.device.motor_turns
            rested, turned = 0 if turns else rested + 1, turned + turns
            if turned * self.scan_ms > ENDLESS_MS:  # a search without a switch in its way
                turned = 0
                self.pulse((RESET,))
                self.pulse((STOP,))
        shown = self.bench.bits
        if "MODULE_OK" in shown and not shown.isdisjoint(MOVING) and not self.bench.device.motor_turns:
            self.wrong.append(f"scan {self.scans}: {sorted(shown)} while the motor rests for long")
        for edge in self.given:
            self.wrong.append(f"scan {edge.scan}: the edge of {edge.bit:#06x} was never obeyed or refused")
        self.given.clear()
        self.pulse((RESET,))
        self.run(100)


def played(seed: int, controller: str = "") -> Sequence:
    """Play a sequence of a seed, over a controller that it chooses itself if none is given."""
    sequence = Sequence(seed, controller)
    for _ in range(sequence.random.randint(1, 3)):
        sequence.episode()
    sequence.settle()
    return sequence


def violations(seed: int, controller: str = "") -> list[str]:
    """Play a sequence; return what was false of it."""
    return played(seed, controller).wrong
