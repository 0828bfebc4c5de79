"""A trace as a value change dump (IEEE 1364), which GTKWave and other waveform viewers show by name.

    $scope module slot1 $end
     $scope module in $end
      $var wire 1 ! COMMAND_ERROR $end           a bit
      $var wire 16 " status_msw [15:0] $end      a word
      $var integer 32 # position $end            a decoded value; x for a missing value
      $var integer 64 $ total $end               a signed integer of the program
      $var wire 8 % dial [7:0] $end              an unsigned integer of the program
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
from ..signals.signal import names_of, whole_numbers
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
        signals: names or patterns, see `Catalog.matching`; empty = all listed signals.
        progress: called for each block with the number of scans read so far.

    Raises:
        UnknownSignalError: a signal does not exist.
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
        for variable in variables:
            variable.register(dump)
        for block in chain([first_block], stream):
            for time_ns, handle, value in _changes(block, variables):
                dump.change(handle, time_ns, value)
            scans += len(block)
            end_ns = int(block.time_ns[-1])
        dump.close(end_ns)  # at the last scan, even if nothing changed in it
    return scans


class Variable:
    """A signal in a dump.

    Attributes:
        handle: pyvcd's object for the variable, from `register`.
    """

    def __init__(self, signal: Signal) -> None:
        self.signal = signal
        self.handle: Any = None
        self._last_value: Any = None  # in the last scan of the previous block; None before the first block

    def register(self, dump: VCDWriter) -> None:
        """Declare the signal in a dump."""
        kind, size, bounds = _declaration(self.signal)
        path = self.signal.path
        scopes = path[:-1][:2]  # viewers show at most two levels: slot and direction
        name = "_".join(path[len(scopes) :])
        self.handle = dump.register_var(scopes, f"{name}{bounds}", kind, size)

    def changes(self, block: Block) -> tuple[Array, list[Any]]:
        """Return the rows of a block in which the value changes, and the new values."""
        values = self.signal.read(block)
        is_new = np.ones(len(values), bool)
        is_new[1:] = values[1:] != values[:-1]
        is_new[0] = self._last_value is None or values[0] != self._last_value
        if values.dtype.kind == "f":  # NaN is unequal to NaN, but a value that stays missing is no change
            is_missing = np.isnan(values)
            was_missing = self._last_value is not None and np.isnan(self._last_value)
            is_new[1:] &= ~(is_missing[1:] & is_missing[:-1])
            is_new[0] &= not (is_missing[0] and was_missing)
        self._last_value = values[-1]
        rows = np.flatnonzero(is_new)
        return rows, _written_values(values[rows], self.signal)


class ExactReal(float):
    """A float that is written with all its digits, since pyvcd's sixteen digits can change its value."""

    @override
    def __format__(self, _spec: str) -> str:
        return repr(float(self))


_DECLARATIONS = {
    SignalKind.BIT: ("wire", 1, ""),
    SignalKind.WORD: ("wire", 16, " [15:0]"),
    SignalKind.VALUE: ("integer", 32, ""),
    SignalKind.MEASURED: ("real", 64, ""),
    SignalKind.NUMBER: ("real", 64, ""),
    SignalKind.CODE: ("string", 1, ""),
}


def _declaration(signal: Signal) -> tuple[str, int, str]:
    """Return a variable's type, size and bounds; viewers show integers as signed, and wires as unsigned."""
    if signal.path == ("cpu", "flags"):
        return "wire", 32, " [31:0]"
    if signal.kind is not SignalKind.NUMBER or not signal.bits:
        return _DECLARATIONS[signal.kind]
    return ("integer", signal.bits, "") if signal.signed else ("wire", signal.bits, f" [{signal.bits - 1}:0]")


def _ascii_word(text: str) -> str:
    """Return text as a single ASCII word, the only form that a dump allows.

    >>> _ascii_word("wait for oil"), _ascii_word("")
    ('wait_for_oil', '""')
    """
    printable = "".join(character if "!" <= character <= "~" else "_" for character in text)
    return printable or '""'


def _written_values(values: Array, signal: Signal) -> list[Any]:
    """Return values in the form that pyvcd needs: numbers, texts, and `x` for a missing value."""
    if signal.kind is SignalKind.CODE:
        return [_ascii_word(name) for name in names_of(values, signal.names)]
    if signal.kind is SignalKind.VALUE:
        numbers, missing = (column.tolist() for column in whole_numbers(values))
        return ["x" if is_missing else number for number, is_missing in zip(numbers, missing, strict=True)]
    plain_values: list[Any] = values.tolist()
    return [ExactReal(value) for value in plain_values] if values.dtype.kind == "f" else plain_values


def _changes(block: Block, variables: Sequence[Variable]) -> Iterator[tuple[int, Any, Any]]:
    """Yield the time, handle and new value of each change, in order of time."""
    rows_by_variable: list[Array] = []
    new_values: list[tuple[Any, Any]] = []  # handle and value of each change, variable by variable
    for variable in variables:
        changed_rows, values = variable.changes(block)
        rows_by_variable.append(changed_rows)
        new_values += [(variable.handle, value) for value in values]
    rows = np.concatenate(rows_by_variable)
    order = np.argsort(rows, kind="stable")
    times = block.time_ns[rows[order]].tolist()
    for change_index, time_ns in zip(order.tolist(), times, strict=True):
        yield time_ns, *new_values[change_index]


FORMAT = ExportFormat(
    name="vcd",
    kind=VCD,
    write=write_vcd,
    help="Write a value change dump for GTKWave and other waveform viewers.",
    contents="changes only, by IEEE 1364: bits as wires, words as vectors, values and signed integers of the "
    "program as integers (`x` for a missing value), unsigned integers as vectors, speeds as reals, in "
    "scopes `slot1`, `in` and `out`; timescale 1 ns",
    reader="GTKWave and other waveform viewers",
)
