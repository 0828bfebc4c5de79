"""A running program: its memory, its tags, its faults, and the scan.

A scan loop calls an engine with its scan; a test calls `step`. Prescan precedes the first scan after power-up
and after program mode.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from scanrack.io_images.annotations import signature_of
from scanrack.io_images.site import Site

from ..interpreter import Interpreter
from ..model.errors import STACK_CODE, LadderFault, MinorFault, ScanEndedError
from ..model.tags import program_of, scoped
from ..state.fault_log import FaultLog
from ..state.lowered import LoweredProgram
from ..state.memory import Memory, Passed, Value, set_initial_bytes
from ..state.scheduler import Scheduler
from .view import Tags
from .whereabouts import Compiled, position_in_program

STEP_MS = 10
"""Default period of `step`, ms."""


class Engine:
    """Runs one lowered program on its own memory, with a compiled scan or the interpreter.

    Attributes:
        scheduler: a controller's scheduler; None if a scan calls one routine.
        now_ns: virtual time of the last scan.
        compiled: the routine of each compiled function.
    """

    memory_type: type[Memory] = Memory
    """Class of its memory; a debugger replaces it."""

    interpreter_type: type[Interpreter] = Interpreter
    """Class for prescan, and for scans of programs that are not compiled."""

    def __init__(
        self,
        lowered: LoweredProgram,
        scanner: Callable[[Engine], Callable[[int], object]] | None = None,
        memory: Memory | None = None,
    ) -> None:
        """Create an engine; `scanner` returns its compiled scan. Without one, the interpreter scans."""
        self.lowered = lowered
        self.memory = memory or self.memory_type(lowered.layout, lowered.presets, lowered.defaults)
        self.memory.put_outputs(lowered.outputs)
        self.tags = Tags(lowered, self.memory)
        self.fault_log = FaultLog(lowered, self.memory)
        self.now_ns = 0
        self.compiled: Compiled = {}
        self.interpreter = self.interpreter_type(lowered, self.memory, self.fault_log, self.call_python)
        self.scheduler = (
            Scheduler(lowered, lowered.schedule, self.memory, self.fault_log) if lowered.schedule else None
        )
        self.interpreter.scheduler = self.scheduler
        self._with_jsr = {
            name: "jsr" in signature_of(function).parameters for name, function in lowered.functions.items()
        }
        self.call_routine: Callable[[str, Sequence[Passed]], Sequence[Passed]] = self.interpreter.run
        self._scan = scanner(self) if scanner else self.interpreter.scan  # a scanner has its own call_routine
        self._rack: object = None  # the scan with the images that are the memory
        self._program_tags: dict[str, Tags] = {}  # views of tags by program, see `tags_of`
        self._started = False  # whether there was a scan
        self._prescanned = False  # whether `prescan` precedes the next scan
        self._first_scan = lowered.layout.leaf("S:FS")

    def compiled_as(self, scanner: Callable[[Engine], Callable[[int], object]]) -> None:
        """Run another compiled form of the program from the next scan on."""
        self._scan = scanner(self)

    @property
    def minor_faults(self) -> tuple[MinorFault, ...]:
        """The latest minor faults, oldest first."""
        return tuple(self.fault_log.minor)

    def __call__(self, scan: Any) -> None:
        """Do one scan of a rack, with `slot`, `now_ns`, `first` and `updated`; may raise a LadderFault."""
        self.attach(scan)
        self._scan_at(scan.now_ns, scan.first)

    def scan_by(self, interpreter: Interpreter, scan: Any) -> None:
        """Do one scan of a rack in an interpreter instead of the compiled program."""
        interpreter.scheduler = self.scheduler
        usual_scan, self._scan = self._scan, interpreter.scan
        try:
            self(scan)
        finally:
            self._scan = usual_scan

    def attach(self, scan: Any) -> None:
        """Use a scan's images as memory; raise a ValueError if the rack lacks a slot the program uses."""
        if scan is not self._rack:
            self.memory.attach(scan.slot, self.lowered.written_inputs)
            self._rack = scan
        if self.memory.copies_inputs:
            self.memory.take_inputs(updated=scan.updated or scan.first)
        self.memory.take_faults(scan.slot)

    def continue_from(self, other: Engine) -> None:
        """Continue after the scans of another engine, without prescan."""
        self.now_ns, self._started = other.now_ns, other._started

    def step(self, ms: float = STEP_MS) -> None:
        """Do one scan without a rack, `ms` after the previous one; may raise a LadderFault."""
        now_ns = self.now_ns + round(ms * 1_000_000) if self._started else 0
        self._scan_at(now_ns, first=not self._started or self._prescanned)

    def prescan(self) -> None:
        """Prescan, as after a change to program mode and back; the next `step` is a first scan."""
        self._prescanned = True
        self.interpreter.prescan()

    def _scan_at(self, now_ns: int, first: bool) -> None:  # positional: keywords cost 1 % of a scan
        """Do one scan; endless recursion is a fault, and an interruption gets a note with its position."""
        self.now_ns = now_ns
        self.fault_log.new_scan(now_ns)
        try:
            self._run_logic(now_ns, first)
        except RecursionError:
            site = Site(self.lowered.name, self.lowered.main, 0, "JSR")
            text = "routines in Python call routines without an end"
            raise LadderFault(site, "JSR", text, STACK_CODE) from None
        except Exception:
            raise
        except BaseException as stop:  # from the watchdog or Ctrl-C
            if position := position_in_program(stop.__traceback__, self.compiled):
                stop.add_note(position)
            raise

    def _run_logic(self, now_ns: int, first: bool) -> None:
        """Run one scan between the opening and closing hooks; TND of an SLC 500 does not skip the hooks."""
        for hook in self.lowered.opening:
            hook(self, first)
        try:
            if first:
                self._first_logic(now_ns)
            else:
                self._scan(now_ns)
        except ScanEndedError:
            self.memory.write(self._first_scan, 0, False)
        for close in self.lowered.closing:
            close(self)

    def _first_logic(self, now_ns: int) -> None:
        """Run the first scan with S:FS on, after prescan; a program that resumes skips both."""
        is_start, self._started = not self._started, True
        if is_start and self.lowered.outputs:
            self._put_outputs()
        is_resumed = is_start and self.lowered.resume is not None
        if is_resumed:
            self.lowered.resume(self)  # type: ignore[misc]
        elif not self._prescanned:
            self.interpreter.prescan()
        self._prescanned = False
        if self.scheduler is not None:
            self.scheduler.begin(now_ns, started=is_resumed)
            self._scan(now_ns)
            return
        self.memory.write(self._first_scan, 0, not is_resumed)
        self._scan(now_ns)
        self.memory.write(self._first_scan, 0, False)

    def _put_outputs(self) -> None:
        """Set the output images of the rack to their initial values."""
        slots = getattr(self._rack, "slot", {})
        for number, data in self.lowered.outputs.items():
            if number in slots:
                set_initial_bytes(slots[number].outputs, data)

    def call_python(self, name: str, inputs: Sequence[Passed]) -> Sequence[Passed]:
        """Call a routine in Python with the tags, the inputs, and `jsr` if it has that parameter."""
        function = self.lowered.functions[name]
        program = program_of(name)
        tags = self.tags_of(program)
        if self._with_jsr[name]:
            results = function(tags, *inputs, jsr=partial(self._jsr_in, program))
        else:
            results = function(tags, *inputs)
        if results is None:
            return ()
        return results if isinstance(results, tuple) else (results,)

    def tags_of(self, program: str) -> Tags:
        """Return a view of the tags by the names that are valid in a program; "" is the controller."""
        if not program:
            return self.tags
        tags = self._program_tags.get(program)
        if tags is None:
            tags = self._program_tags[program] = Tags(self.lowered, self.memory, program)
        return tags

    def _jsr_in(self, program: str, routine: str, *inputs: Value) -> tuple[Passed, ...]:
        """Call a routine by name from Python."""
        name = scoped(program, routine).upper()
        target = self.lowered.routines.get(name)
        if target is None:
            names = ", ".join(row.name for row in self.lowered.routines.values())
            raise ValueError(f"no routine {routine}; routines are {names}")
        expected = len(target.parameters or ())
        if expected != len(inputs):
            raise ValueError(f"routine {target.name} is called with {len(inputs)} inputs; must be {expected}")
        return tuple(self.call_routine(name, inputs))
