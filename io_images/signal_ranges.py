"""Channels of analog cards: signals in V or mA, their raw numbers, and the range bits.

    range          normal        converted          (numbers are limited to this range)
    -10..10 V      -10 to 10     -10.5 to 10.5
    4..20 mA       4 to 20       3.2 to 21          below 4 mA, as in an open circuit: under-range

The over-range and under-range bits report a signal outside the normal range; each also sets the channel's
status bit.

Sources: 1769-UM002B, Compact I/O Analog Modules, tables 3.7 and 3.17 (ranges and formats), page 3-3 (bits);
1762-RM001C, I/O Configuration (1762-IF4); 1762-IN016D, pages 14 and 15 (1762-OF4); 1769-IN087A, page 15
(1769-OF4).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from math import floor

from .dataclass import dataclass

FULL_RAW = 32_767
"""Raw number at the end of a range of a 16-bit card."""

STEPS_12 = 4095
"""Steps of a 1762-OF4: 12 bits, in bits 3 to 14 of the word; bits 0 to 2 are ignored."""

RAW_LANDMARKS = (0.0, 1.0, -1.0, 6241.0, 31_206.0, 32_767.0, -32_768.0)
"""Raw numbers to test with: 4 and 20 mA, and the ends of a word."""

PID_FULL = 16_383
PERCENT_FULL = 10_000
THOUSANDTHS = 1000

SIGNAL_MAX = 30
"""Maximum signal in a rack file, V or mA."""


@dataclass(frozen=True, slots=True)
class SignalRange:
    """A signal range of a channel."""

    name: str  # in rack files
    unit: str  # V or mA
    low: Fraction  # lower end of the normal range
    high: Fraction
    least: Fraction  # lowest converted signal
    most: Fraction

    @property
    def landmarks(self) -> tuple[float, ...]:
        """Signals for tests: the ends and middle of the range, just beyond the ends, and far beyond."""
        step = (self.high - self.low) / 100
        middle_value = (self.low + self.high) / 2
        values = (self.low, self.high, middle_value, self.high + step, self.low - step)
        far_values = (self.most, self.least, Fraction(0), self.most + 1)
        return tuple(map(float, dict.fromkeys((*values, *far_values))))


def _range(unit: str, low: int, high: int, least: str, most: str) -> tuple[str, SignalRange]:
    name = f"{low}..{high} {unit}"
    return name, SignalRange(name, unit, Fraction(low), Fraction(high), Fraction(least), Fraction(most))


RANGES: Mapping[str, SignalRange] = dict(
    (
        _range("V", -10, 10, "-10.5", "10.5"),
        _range("V", 0, 5, "0", "5.25"),
        _range("V", 0, 10, "0", "10.5"),
        _range("mA", 4, 20, "3.2", "21"),
        _range("V", 1, 5, "0.5", "5.25"),
        _range("mA", 0, 20, "0", "21"),
    )
)
"""The ranges by name, in the order of the cards' configuration bits."""


def _raw(signal: Fraction, signal_range: SignalRange) -> int:
    """Return a raw number proportional to the signal; 32,767 is the end of the range."""
    return int(signal / signal_range.most * FULL_RAW)


def _raw_12(signal: Fraction, signal_range: SignalRange) -> int:
    return floor(signal / signal_range.most * STEPS_12) * 8


def _pid_12(signal: Fraction, signal_range: SignalRange) -> int:
    return floor(signal / signal_range.most * STEPS_12) * 4


def _engineering(signal: Fraction, signal_range: SignalRange) -> int:
    return _nearest(signal * THOUSANDTHS)


def _pid(signal: Fraction, signal_range: SignalRange) -> int:
    return _nearest((signal - signal_range.low) / (signal_range.high - signal_range.low) * PID_FULL)


def _percent(signal: Fraction, signal_range: SignalRange) -> int:
    return _nearest((signal - signal_range.low) / (signal_range.high - signal_range.low) * PERCENT_FULL)


def _nearest(value: Fraction) -> int:
    """Return the nearest whole number; halves are rounded away from zero."""
    return floor(value + Fraction(1, 2)) if value >= 0 else -floor(-value + Fraction(1, 2))


Convert = Callable[[Fraction, SignalRange], int]

FORMATS: Mapping[str, Convert] = {
    "raw": _raw,
    "engineering": _engineering,
    "pid": _pid,
    "percent": _percent,
}
"""Functions that convert a signal to a number, by data format.

The numbers are proportional, in thousandths of a V or mA, 0 to 16,383, or 0 to 10,000.
"""

FORMATS_12: Mapping[str, Convert] = {"raw": _raw_12, "pid": _pid_12}
"""Data formats of a 1762-OF4, with 32,760 or 16,380 at the end of the range."""


@dataclass(frozen=True, slots=True)
class Channel:
    """A channel with a signal range and a data format."""

    range: SignalRange
    convert: Convert

    def word(self, signal: Fraction) -> int:
        """Return the raw number of a signal, limited to the converted range.

        >>> Channel(RANGES["4..20 mA"], FORMATS["raw"]).word(Fraction(20))
        31206
        """
        return self.convert(min(max(signal, self.range.least), self.range.most), self.range)

    def limited(self, word: int) -> int:
        """Return an output's raw number, limited to the converted range."""
        return min(max(word, self.word(self.range.least)), self.word(self.range.most))

    def signal_beyond(self, signal: Fraction) -> tuple[bool, bool]:
        """Return whether a signal is above the normal range, and whether it is below."""
        return signal > self.range.high, signal < self.range.low

    def word_beyond(self, word: int) -> tuple[bool, bool]:
        """Return whether an output's raw number is above the normal range, and whether it is below."""
        return word > self.word(self.range.high), word < self.word(self.range.low)
