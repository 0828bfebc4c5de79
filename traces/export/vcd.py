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

The timescale is 1 ns, and only changes are written. pyvcd writes the file; this module chooses types, names,
values, and the order of simultaneous changes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override
from vcd import VCDWriter

from ..files.guard import beginning
from ..files.newfile import Target, new_file
from ..read.reader import Trace
from ..signals import ALL, Block, Catalog, Selection, Signal, SignalKind, blocks
from ..signals.signal import named, whole_numbers
from .format import ExportFormat

VCD = beginning("a value change dump", b"$version", b"$date", b"$comment", b"$timescale")

Array = NDArray[Any]


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
        path: path of the file, which is replaced if it exists.
        signals: names or patterns, see `Catalog.matching`; empty = everything.
        progress: called at each block with the number of scans read so far.

    Raises:
        UnknownSignalError: no such signal.
        EmptySelectionError: no scan is in the selection.
    """
    catalog = Catalog.of(trace)
    chosen_signals = catalog.matching(signals) if signals else [catalog[name] for name in catalog]
    variables = [Variable(signal) for signal in chosen_signals]
    scans = 0
    stream = blocks(trace, selection, progress=progress)
    first_block = next(stream)
    begin_ns = int(first_block.time_ns[0])
    with (
        new_file(path, VCD, encoding="ascii") as file,
        VCDWriter(file, "1 ns", "", version="scanrack", check_values=False, init_timestamp=begin_ns) as dump,
    ):
        for declared in variables:
            declared.register(dump)
        for block in chain([first_block], stream):
            for time_ns, variable, value in _changes(block, variables):
                dump.change(variable, time_ns, value)
            scans += len(block)
            end_ns = int(block.time_ns[-1])
        dump.close(end_ns)  # at the last scan, even if nothing changed in it
    return scans


class Variable:
    """A signal in a dump.

    Attributes:
        dumped: the variable of the writer.
    """

    def __init__(self, signal: Signal) -> None:
        self.signal = signal
        self.dumped: Any = None
        self._last: Any = None

    def register(self, dump: VCDWriter) -> None:
        """Declare the signal in a dump."""
        kind, size, bounds = _declared(self.signal)
        path = self.signal.path
        name = path[-1] if len(path) < 4 else "_".join(path[2:])
        self.dumped = dump.register_var(path[:-1][:2], f"{name}{bounds}", kind, size)

    def changes(self, block: Block) -> tuple[Array, list[Any]]:
        """Return the rows of a block with a new value, and the values."""
        values = self.signal.read(block)
        is_new = np.ones(len(values), bool)
        is_new[1:] = values[1:] != values[:-1]
        is_new[0] = self._last is None or values[0] != self._last
        if values.dtype.kind == "f":  # a missing value that follows a missing value is no change
            none = np.isnan(values)
            is_new[1:] &= ~(none[1:] & none[:-1])
            is_new[0] &= not (none[0] and self._last is not None and np.isnan(self._last))
        self._last = values[-1]
        rows = np.flatnonzero(is_new)
        return rows, _dumped(values[rows], self.signal)


class ExactReal(float):
    """A number that is written with all its digits: the sixteen of pyvcd may be a different number."""

    @override
    def __format__(self, _spec: str) -> str:
        return repr(float(self))


_DECLARED = {
    SignalKind.BIT: ("wire", 1, ""),
    SignalKind.WORD: ("wire", 16, " [15:0]"),
    SignalKind.VALUE: ("integer", 32, ""),
    SignalKind.MEASURED: ("real", 64, ""),
    SignalKind.NUMBER: ("real", 64, ""),
    SignalKind.CODE: ("string", 1, ""),
}


def _declared(signal: Signal) -> tuple[str, int, str]:
    """Return a variable's type, size and bounds; viewers show integers with a sign, and wires without."""
    if signal.path == ("cpu", "flags"):
        return "wire", 32, " [31:0]"
    if signal.kind is not SignalKind.NUMBER or not signal.bits:
        return _DECLARED[signal.kind]
    return ("integer", signal.bits, "") if signal.signed else ("wire", signal.bits, f" [{signal.bits - 1}:0]")


def _word(text: str) -> str:
    """Return a text as a single ASCII word, the only form that a dump allows.

    >>> _word("wait for oil"), _word("")
    ('wait_for_oil', '""')
    """
    printable = "".join(character if "!" <= character <= "~" else "_" for character in text)
    return printable or '""'


def _dumped(values: Array, signal: Signal) -> list[Any]:
    """Return values in the writer's form: numbers, texts, and `x` for a missing value."""
    if signal.kind is SignalKind.CODE:
        return [_word(name) for name in named(values, signal.names)]
    if signal.kind is SignalKind.VALUE:
        numbers, is_missing = whole_numbers(values)
        number_pairs = zip(numbers.tolist(), is_missing.tolist(), strict=True)
        return ["x" if none else number for number, none in number_pairs]
    plain_values: list[Any] = values.tolist()
    return [ExactReal(value) for value in plain_values] if values.dtype.kind == "f" else plain_values


def _changes(block: Block, variables: Sequence[Variable]) -> Iterator[tuple[int, Any, Any]]:
    """Yield time, variable and new value of each change, in order of time."""
    changes = [variable.changes(block) for variable in variables]
    variable_changes = [
        (variable.dumped, value)
        for variable, (_, values) in zip(variables, changes, strict=True)
        for value in values
    ]
    rows = np.concatenate([rows for rows, _ in changes])
    order = np.argsort(rows, kind="stable")
    times = block.time_ns[rows[order]].tolist()
    for change_index, time_ns in zip(order.tolist(), times, strict=True):
        yield time_ns, *variable_changes[change_index]


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
