"""Timers, edges and counters of IEC 61131-3 as objects, called once in each scan in virtual time.

    class Line(Logic):
        start = Input("start")
        warning = OnDelay("500 ms")

        def every_scan(self) -> None:
            self.lamp = self.warning(self.start)

| object | IEC | when it is true |
|---|---|---|
| `OnDelay("2 s")` | TON | once its input has been true for that time |
| `OffDelay("2 s")` | TOF | while its input is true, and for that time after |
| `Pulse("2 s")` | TP | for that time after its input rises |
| `Rise()` | R_TRIG | for one call, when its input rises |
| `Fall()` | F_TRIG | for one call, when its input falls |
| `Counter(5)` | CTU | once its input has risen 5 times |
| `DownCounter(5)` | CTD | once its input has risen 5 times since it was loaded |

A call returns the result, which stays until the next call: `if self.warning:`. A first scan (after power-up
or program mode) resets the object. As in IEC 61131-3, `Rise`, `Counter` and `DownCounter` treat an input that
is true at their first call as a rise; ONS, CTU and CTD of a ladder do not.
"""

from __future__ import annotations

from typing import ClassVar

from scanrack.io_images.amci3601.parameters import require
from scanrack.io_images.times import parse_time
from typing_extensions import override

from .parts import Clock, Level, Part, Slots

LEAST, MOST = -(2**31), 2**31 - 1
"""The range of a counter, which is the range of a DINT."""


class Block(Level):
    """An object that is called once per scan, and is true or false until the next call."""

    def __init__(self) -> None:
        super().__init__()
        self._result = False

    def __bool__(self) -> bool:
        return self._result

    @override
    def reset_part(self) -> None:
        self._result = False


class EdgeBlock(Block):
    """A block that stores the input of the previous call."""

    def __init__(self) -> None:
        super().__init__()
        self._was_on = False

    @override
    def reset_part(self) -> None:
        super().reset_part()
        self._was_on = False

    def _rises(self, on: object) -> bool:
        """Store the input; return whether it has risen since the previous call."""
        was_on, self._was_on = self._was_on, bool(on)
        return self._was_on and not was_on


class PresetBlock(Block):
    """A block whose preset an online edit may change while the block continues."""

    preset_name: ClassVar[str]

    @override
    def continues_as(self, edited: Part) -> bool:
        return type(self) is type(edited)

    @override
    def continue_as(self, edited: Part) -> None:
        if self._part_made != edited._part_made:
            setattr(self, self.preset_name, getattr(edited, self.preset_name))
        super().continue_as(edited)


class Timer(PresetBlock):
    """A timer with a time such as "500 ms"; raises a ValueError for an invalid time."""

    preset_name = "preset_ns"

    def __init__(self, time: str) -> None:
        super().__init__()
        self.preset_ns = parse_time(time)  # a change takes effect at the next call
        self._clock: Clock | None = None  # None before the first scan
        self._since_ns: int | None = None  # start of the current run; None while stopped
        self._elapsed_ns = 0

    @property
    def elapsed_ns(self) -> int:
        """Elapsed time at its last call, up to its preset [ET]."""
        return self._elapsed_ns

    @override
    def attach(self, slots: Slots, clock: Clock) -> None:
        self._clock = clock

    @override
    def reset_part(self) -> None:
        super().reset_part()
        self._stop()

    def _run(self) -> bool:
        """Start or continue the timer; return whether its time is over."""
        if self._clock is None:
            raise ValueError(f"{self.name or type(self).__name__} has no time before the first scan")
        now_ns = self._clock.now_ns
        if self._since_ns is None:
            self._since_ns = now_ns
        self._elapsed_ns = min(now_ns - self._since_ns, self.preset_ns)
        return self._elapsed_ns >= self.preset_ns

    def _stop(self) -> None:
        self._since_ns, self._elapsed_ns = None, 0


class OnDelay(Timer):
    """True once its input has been true for a time without interruption [TON]."""

    def __call__(self, on: object) -> bool:
        """Evaluate this scan's input."""
        if on:
            self._result = self._run()
        else:
            self._stop()
            self._result = False
        return self._result


class OffDelay(Timer):
    """True while its input is true, and for a time after [TOF]."""

    def __call__(self, on: object) -> bool:
        """Evaluate this scan's input."""
        if on:
            self._stop()
            self._result = True
        elif self._result:
            self._result = not self._run()
        return self._result


class Pulse(Timer, EdgeBlock):
    """True for a time after its input rises; other rises during that time are ignored [TP]."""

    def __call__(self, on: object) -> bool:
        """Evaluate this scan's input."""
        rises = self._rises(on)
        if rises and not self._result:
            self._stop()
        if rises or self._result:
            self._result = not self._run()
        if not on and not self._result:
            self._stop()
        return self._result


class Rise(EdgeBlock):
    """True for one call when its input rises [R_TRIG]."""

    def __call__(self, on: object) -> bool:
        """Evaluate this scan's input."""
        self._result = self._rises(on)
        return self._result


class Fall(EdgeBlock):
    """True for one call when its input falls [F_TRIG]."""

    def __call__(self, on: object) -> bool:
        """Evaluate this scan's input."""
        self._result, self._was_on = self._was_on and not on, bool(on)
        return self._result


class AnyCounter(PresetBlock, EdgeBlock):
    """A counter; raises a ValueError for a preset out of range."""

    preset_name = "preset"

    def __init__(self, preset: int) -> None:
        super().__init__()
        require("preset", preset, LEAST, MOST)
        self.preset = preset  # number of rises to count, -2,147,483,648 to 2,147,483,647
        self.value = 0  # the count [CV]

    @override
    def reset_part(self) -> None:
        super().reset_part()
        self.value = 0


class Counter(AnyCounter):
    """Counts the rises of its input; true once the count reaches its preset [CTU]."""

    def __call__(self, on: object, *, reset: object = False) -> bool:
        """Evaluate this scan's input; `reset` clears the count and ignores a rise in the same scan."""
        rises = self._rises(on)
        if reset:
            self.value = 0
        elif rises and self.value < MOST:
            self.value += 1
        self._result = self.value >= self.preset
        return self._result


class DownCounter(AnyCounter):
    """Counts down at each rise of its input; true at 0 and below [CTD]. It starts at 0, so load it first."""

    def __call__(self, on: object, *, load: object = False) -> bool:
        """Evaluate this scan's input; `load` sets the preset and ignores a rise in the same scan."""
        rises = self._rises(on)
        if load:
            self.value = self.preset
        elif rises and self.value > LEAST:
            self.value -= 1
        self._result = self.value <= 0
        return self._result
