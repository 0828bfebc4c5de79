"""The interpreter of user programs of a PMC006x3s [5].

An instruction takes 1 ms (interpretation), so instructions are due every 1 ms, counted from the start or from
the end of a pause. WAIT checks its condition at these times; while the condition is false, nothing is due.

    start   |CNTC|ROT |WAIT......(motor moves)......|CNT1|
    ms      0    1    2    3    4 ...          n    n+1

After the last line the program ends, but the motor continues. The reset key stays bound ("done once in the
program to take effect globally" [5.1.2.7]): it also stops the motor after the program's end, and the program
continues at the key's line.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from scanrack.io_images.pmc006.program import UserInstruction
from scanrack.io_images.pmc006.status import Gpio, Level, Status1

from ...kinematics import FOREVER
from .memory import Memory
from .pins import Pin, Pmc006Pins
from .pmc006_motor import SimulatedPmc006Axis

INSTRUCTION_NS = 1_000_000
"""Duration of a user instruction (interpretation)."""

RESET_PIN, PAUSE_PIN = Pin.FSET, Pin.GPI2
"""This hardware's pins for GPI1 and GPI2 of the manual [5.1.2.7] (interpretation)."""


class ProgramHost(Protocol):
    """The controller's interface for its user program."""

    memory: Memory
    pins: Pmc006Pins
    axis: SimulatedPmc006Axis
    gpio: Gpio
    now_ns: int

    @property
    def levels(self) -> Level:
        """The pins, as instruction x reads them."""

    def execute(self, code: int, data: int) -> int:
        """Carry out an instruction as if it came from the line; return the response data."""

    def abort(self) -> None:
        """End any motion at once."""


class Interpreter:
    """Runs the user program.

    Attributes:
        line: the next line, from 0.
        counter: the internal counter.
        equal: the flag that CMP sets.
        running: whether the program has started and has not ended.
        paused: whether the key of PAUSE_EN has paused the program.
    """

    def __init__(self, host: ProgramHost) -> None:
        self.host = host
        self._due_ns = 0
        self.stop()

    def start(self, now_ns: int) -> None:
        """Start the program at line 0, with counter and flag set to 0 and no keys bound."""
        self.stop()
        self.running = True
        self._due_ns = now_ns

    def stop(self) -> None:
        """Stop the program and reset its state; the motor continues."""
        self.running = self.paused = self.equal = False
        self.line = self.counter = 0
        self._reset_line: int | None = None
        self._pause_bound = False

    def next_ns(self, now_ns: int) -> int:
        """Return the instant of the next instruction, or FOREVER if there is none."""
        if not self.running or self.paused:
            return FOREVER
        if now_ns < self._due_ns:
            return self._due_ns
        line = self._line()
        if line is not None and line.op == "WAIT" and not self._is_met(line):
            return FOREVER
        return self._due_ns - (self._due_ns - now_ns) // INSTRUCTION_NS * INSTRUCTION_NS

    def tick(self, now_ns: int) -> None:
        """Carry out the instruction that is due at `now_ns`, if any."""
        if self.next_ns(now_ns) != now_ns:
            return
        line = self._line()
        if line is None:
            self.running = False
        elif line.op != "WAIT" or self._is_met(line):
            self.line += 1
            EFFECTS[line.op](self, line)
            self._due_ns = now_ns + INSTRUCTION_NS

    def on_pins(self, fallen: int) -> None:
        """Act on the RESET_EN and PAUSE_EN keys when their pins go low."""
        now_ns = self.host.now_ns
        if fallen & RESET_PIN and self._reset_line is not None:
            self.host.abort()
            self.running = True
            self.line = self._reset_line
            self._due_ns = now_ns + INSTRUCTION_NS
        if fallen & PAUSE_PIN and self._pause_bound and self.running:
            self.paused = not self.paused
            self._due_ns = max(self._due_ns, now_ns)

    def _line(self) -> UserInstruction | None:
        lines = self.host.memory.lines
        return lines[self.line] if self.line < len(lines) else None

    # -- conditions --------------------------------------------------------------------------

    def _is_met(self, line: UserInstruction) -> bool:
        """Return whether the condition of a WAIT is met."""
        _, condition = WAIT_OPTIONS[line.option]
        return condition(self) == bool(line.data)

    def compare(self, line: UserInstruction) -> None:
        """Compare, and set the flag that JEQ and JNE test."""
        _, value = CMP_OPTIONS[line.option]
        self.equal = value(self) == line.data

    # -- effects -----------------------------------------------------------------------------

    def send(self, char: str, data: int) -> None:
        """Execute the instruction that has a character code; ignore a refusal."""
        self.host.execute(ord(char), data)

    def count(self) -> None:
        """Add 1 to the counter."""
        self.counter += 1

    def clear_counter(self) -> None:
        """Set the counter to 0."""
        self.counter = 0

    def jump_if(self, condition: bool, line: UserInstruction) -> None:
        """Continue at a jump's target if the condition is true."""
        if condition:
            self.line = line.data

    def set_ramps(self, line: UserInstruction) -> None:
        """Set both coefficients (interpretation)."""
        self.send("u", line.data)
        self.send("o", line.data)

    def set_speed(self, line: UserInstruction) -> None:
        """Set the maximum speed; ignore 0 (interpretation)."""
        if line.data:
            self.send("v", line.data)

    def set_output(self, line: UserInstruction) -> None:
        """Set the level of an output; only port 1 exists (interpretation)."""
        if line.option == 1:
            gpio = self.host.gpio
            self.host.gpio = gpio | Gpio.GPIO8 if line.data else gpio & ~Gpio.GPIO8

    def bind_reset(self, line: UserInstruction) -> None:
        """Make GPI1 the reset key, or release it."""
        self._reset_line = line.data if line.option else None

    def bind_pause(self, line: UserInstruction) -> None:
        """Make GPI2 the pause key, or release it."""
        self._pause_bound = bool(line.option)


EFFECTS: dict[str, Callable[[Interpreter, UserInstruction], None]] = {
    "ROT": lambda program, line: program.send("s", line.data),
    "MIC": lambda program, line: program.send("m", line.data),
    "DIR": lambda program, line: program.send("d", line.data),
    "EXTEN": lambda program, line: program.send("f", line.data),
    "FREE": lambda program, line: program.send("g", line.data),
    "CLR2": lambda program, line: program.send("l", 0),
    "CLR1": lambda program, line: program.send("b", 0),
    "VSET": Interpreter.set_speed,
    "ACC": Interpreter.set_ramps,
    "TRIG": lambda program, line: program.send("J", line.data),
    "CNT1": lambda program, line: program.count(),
    "CNTC": lambda program, line: program.clear_counter(),
    "JMP": lambda program, line: program.jump_if(True, line),
    "JNE": lambda program, line: program.jump_if(not program.equal, line),
    "JEQ": lambda program, line: program.jump_if(program.equal, line),
    "WAIT": lambda program, line: None,
    "OUT": Interpreter.set_output,
    "CMP": Interpreter.compare,
    "RESET_EN": Interpreter.bind_reset,
    "PAUSE_EN": Interpreter.bind_pause,
}
"""The function that carries out each user instruction [5.1.1]."""


def _level(pin: Pin) -> Callable[[Interpreter], bool]:
    return lambda program: bool(program.host.pins.levels & pin)


def _flag(flag: Status1) -> Callable[[Interpreter], bool]:
    return lambda program: bool(program.host.axis.flags & flag)


WAIT_OPTIONS: dict[int, tuple[str, Callable[[Interpreter], bool]]] = {
    1: ("motor idle", lambda program: not program.host.axis.moving),
    2: ("EXT1 level", _level(Pin.EXT1)),
    3: ("EXT2 level", _level(Pin.EXT2)),
    4: ("GPI1 level", _level(RESET_PIN)),
    5: ("GPI2 level", _level(PAUSE_PIN)),
    6: ("EXT1 flag", _flag(Status1.EXT1)),
    7: ("EXT2 flag", _flag(Status1.EXT2)),
}
"""The value that WAIT compares with its data, as a name and a function, by option (interpretation)."""


CMP_OPTIONS: dict[int, tuple[str, Callable[[Interpreter], int]]] = {
    1: ("counter", lambda program: program.counter),
    2: ("EXT1 level", _level(Pin.EXT1)),
    3: ("EXT2 level", _level(Pin.EXT2)),
    4: ("EXT1 flag", _flag(Status1.EXT1)),
    5: ("EXT2 flag", _flag(Status1.EXT2)),
    6: ("all inputs, as instruction x reads them", lambda program: int(program.host.levels)),
}
"""The value that CMP compares with its data, as a name and a function, by option (interpretation)."""
