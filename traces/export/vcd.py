"""A trace as a value change dump (IEEE 1364), which GTKWave and other waveform viewers show by name.

    $scope module slot1 $end
     $scope module in $end
      $var wire 1 ! COMMAND_ERROR $end           a bit
      $var wire 16 " status_msw [15:0] $end      a word
      $var integer 32 # position $end            a decoded value; x where there is none
      $var integer 64 $ total $end               a signed integer of the program's
      $var wire 8 % dial [7:0] $end              an unsigned one
      $var real 64 & level $end                  a number with a fraction
      $var string 1 ' step $end                  the name that a code stands for

The timescale is 1 ns, and only what changes is written.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..files.guard import beginning
from ..files.newfile import Target, new_file
from ..read.reader import Trace
from ..signals import ALL, Block, Catalog, Selection, Signal, SignalKind, blocks
from ..signals.signal import named, whole_numbers
from .format import ExportFormat

VCD = beginning("a value change dump", b"$version", b"$date", b"$comment", b"$timescale")

Array = NDArray[Any]

_FIRST, _SYMBOLS = 33, 94  # the printable letters of ASCII, from which identifiers are made


def write_vcd(
    trace: Trace,
    path: Target,
    signals: Sequence[str] = (),
    selection: Selection = ALL,
    *,
    progress: Callable[[int], None] = lambda scans: None,
) -> int:
    """Write a trace as a VCD file; return the number of scans read.

    Args:
        path: of the file, replaced if it exists.
        signals: names or patterns, see `Catalog.matching`; empty = everything.
        progress: called at each block with the number of scans read so far.

    Raises:
        UnknownSignalError: no such signal.
        EmptySelectionError: no scan is in the selection.
    """
    catalog = Catalog.of(trace)
    wanted = catalog.matching(signals) if signals else [catalog[name] for name in catalog]
    variables = [Variable(signal, _identifier(place)) for place, signal in enumerate(_in_scopes(wanted))]
    scans = 0
    stream = blocks(trace, selection, progress=progress)
    first = next(stream)
    with new_file(path, VCD, encoding="ascii") as file:
        file.writelines(_head(variables))
        for block in chain([first], stream):
            file.writelines(_changes(block, variables))
            scans += len(block)
            end_ns = int(block.time_ns[-1])
        file.write(f"#{end_ns}\n")  # the last scan, though nothing may have changed in it
    return scans


class Variable:
    """A signal in a dump."""

    def __init__(self, signal: Signal, identifier: str) -> None:
        self.signal = signal
        self._identifier = identifier
        self._last: Any = None

    def declaration(self) -> str:
        """Return its declaration."""
        kind, size, bounds = _declared(self.signal)
        name = self.signal.path[-1] if len(self.signal.path) < 4 else "_".join(self.signal.path[2:])
        return f"$var {kind} {size} {self._identifier} {name}{bounds} $end\n"

    def changes(self, block: Block) -> tuple[Array, list[str]]:
        """Return the rows of a block with a new value, and a line for each."""
        values = self.signal.read(block)
        new = np.ones(len(values), bool)
        new[1:] = values[1:] != values[:-1]
        new[0] = self._last is None or values[0] != self._last
        if values.dtype.kind == "f":  # a missing value after a missing value is no change
            none = np.isnan(values)
            new[1:] &= ~(none[1:] & none[:-1])
            new[0] &= not (none[0] and self._last is not None and np.isnan(self._last))
        self._last = values[-1]
        rows = np.flatnonzero(new)
        if self.signal.kind is SignalKind.CODE:
            return rows, [
                f"s{_word(name)} {self._identifier}\n" for name in named(values[rows], self.signal.names)
            ]
        return rows, _lines(values[rows], self.signal, self._identifier)


_DECLARED = {
    SignalKind.BIT: ("wire", 1, ""),
    SignalKind.WORD: ("wire", 16, " [15:0]"),
    SignalKind.VALUE: ("integer", 32, ""),
    SignalKind.MEASURED: ("real", 64, ""),
    SignalKind.NUMBER: ("real", 64, ""),
    SignalKind.CODE: ("string", 1, ""),
}


def _declared(signal: Signal) -> tuple[str, int, str]:
    """Return a variable's type, size and bounds: viewers show an integer with its sign, a wire without."""
    if signal.path == ("cpu", "flags"):
        return "wire", 32, " [31:0]"
    if signal.kind is not SignalKind.NUMBER or not signal.bits:
        return _DECLARED[signal.kind]
    return ("integer", signal.bits, "") if signal.signed else ("wire", signal.bits, f" [{signal.bits - 1}:0]")


def _word(text: str) -> str:
    """Return a text as a word of ASCII, the only form in a dump.

    >>> _word("wait for oil"), _word("")
    ('wait_for_oil', '""')
    """
    plain = "".join(each if "!" <= each <= "~" else "_" for each in text)
    return plain or '""'


def _lines(values: Array, signal: Signal, identifier: str) -> list[str]:
    if signal.kind is SignalKind.BIT:
        return [f"{value:d}{identifier}\n" for value in values.tolist()]
    if signal.kind is SignalKind.VALUE:
        numbers, missing = whole_numbers(values)
        return [
            f"bx {identifier}\n" if none else f"b{number & 0xFFFF_FFFF:b} {identifier}\n"
            for number, none in zip(numbers.tolist(), missing.tolist(), strict=True)
        ]
    if values.dtype.kind == "f":
        return [f"r{value!r} {identifier}\n" for value in values.tolist()]
    mask = (1 << 8 * values.itemsize) - 1
    return [f"b{value & mask:b} {identifier}\n" for value in values.tolist()]


def _changes(block: Block, variables: Sequence[Variable]) -> Iterator[str]:
    found = [variable.changes(block) for variable in variables]
    lines = [line for _, texts in found for line in texts]
    rows = np.concatenate([rows for rows, _ in found])
    order = np.argsort(rows, kind="stable")
    times = block.time_ns[rows[order]].tolist()
    last = None
    for place, time_ns in zip(order.tolist(), times, strict=True):
        if time_ns != last:
            yield f"#{time_ns}\n"
            last = time_ns
        yield lines[place]


def _head(variables: Sequence[Variable]) -> Iterator[str]:
    yield "$version scanrack $end\n$timescale 1 ns $end\n"
    open_: tuple[str, ...] = ()
    for variable in variables:
        scopes = variable.signal.path[:-1][:2]
        common = sum(1 for _ in _same(open_, scopes))
        yield "$upscope $end\n" * (len(open_) - common)
        yield from (f"$scope module {scope} $end\n" for scope in scopes[common:])
        yield variable.declaration()
        open_ = scopes
    yield "$upscope $end\n" * len(open_) + "$enddefinitions $end\n"


def _same(left: Sequence[str], right: Sequence[str]) -> Iterator[str]:
    """Yield the common beginning of two lists."""
    for one, other in zip(left, right, strict=False):
        if one != other:
            return
        yield one


def _in_scopes(signals: Iterable[Signal]) -> list[Signal]:
    scopes: dict[tuple[str, ...], None] = {}
    signals = list(signals)
    for signal in signals:
        scopes.setdefault(signal.path[:-1][:2])
    order = {scope: place for place, scope in enumerate(scopes)}
    return sorted(signals, key=lambda signal: order[signal.path[:-1][:2]])


def _identifier(number: int) -> str:
    """Return the short name of a variable.

    >>> _identifier(0), _identifier(93), _identifier(94)
    ('!', '~', '!!')
    """
    text = chr(_FIRST + number % _SYMBOLS)
    return text if number < _SYMBOLS else _identifier(number // _SYMBOLS - 1) + text


FORMAT = ExportFormat(
    name="vcd",
    kind=VCD,
    write=write_vcd,
    help="Write a value change dump, for GTKWave and its like.",
    holds="changes only, by IEEE 1364: bits as wires, words as vectors, values and signed integers of the "
    "program as integers (`x` where there is none), unsigned ones as vectors, speeds as reals, in "
    "scopes `slot1`, `in` and `out`; timescale 1 ns",
    reader="GTKWave and other waveform viewers",
)
