"""`scanrack export TRACE --csv OUT`, or another format in `traces.export.formats`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import asdict, make_dataclass
from pathlib import Path
from typing import Annotated, Any

import typer
from scanrack.terminal.complaints import reported_mistakes
from scanrack.terminal.grouped import grouped
from scanrack.terminal.reading import itself, print_notes, reading
from scanrack.terminal.shared_options import QuietOption, RangeOption, TraceArgument, selection
from scanrack.terminal.status import size_of
from scanrack.terminal.terminal import say
from scanrack.traces.export import formats
from scanrack.traces.export.format import ExportFormat
from scanrack.traces.files.guard import check_output
from scanrack.traces.read.reader import Trace, open_trace
from scanrack.traces.signals import Catalog, SignalKind

STDOUT = Path("-")
"""The file name that means standard output."""


def _targets() -> type[Any]:
    """Return a dataclass with an option for each format."""
    of_formats: list[tuple[str, Any, None]] = [
        (
            format_.name,
            Annotated[Path | None, typer.Option(format_.option, metavar="OUT", help=format_.help)],
            None,
        )
        for format_ in formats.FORMATS
    ]
    return make_dataclass("Targets", of_formats)


def _export_command(
    trace: TraceArgument,
    targets: Any,
    signal: Annotated[
        list[str] | None,
        typer.Option(
            "--signal",
            metavar="PATTERN",
            help="Only signals with this name, such as 'slot1.in.*'; may be repeated.",
            show_default="all bits and values",
        ),
    ] = None,
    bits: Annotated[
        bool, typer.Option("--bits", help="Only signals of one bit, for logic analyzers.")
    ] = False,
    ranges: RangeOption = None,
    quiet: QuietOption = False,
) -> None:
    """Convert a trace for other programs.

    OUT is a file, or - for standard output.

    Examples:
        scanrack export run.mcap --vcd run.vcd --range 1.5s:3s

    Exit status: 0 done, 2 the trace or an option can't be used, 3 a file can't be written.
    """
    with reported_mistakes():
        selected = selection(ranges)
        paths = asdict(targets)
        outputs = [
            (export_format, paths[export_format.name])
            for export_format in formats.FORMATS
            if paths[export_format.name] is not None
        ]
        _check(outputs, trace, choice="--signal" if signal else "--bits" if bits else "")
        for format_, target in outputs:
            to_stdout = target == STDOUT
            stdout = sys.stdout.buffer if format_.binary else sys.stdout
            with open_trace(trace) as opened, reading(opened, selected, quiet=quiet) as progress:
                into = stdout if to_stdout else target
                signals = [_chosen(opened, signal or (), bits=bits)] if format_.selects_signals else []
                count = format_.write(opened, into, *signals, selected, progress=progress)
            if not quiet:
                size = "" if to_stdout else f", {size_of(target)}"
                say(f"{target}: {count:,} scans{size}", err=to_stdout)
            print_notes(opened)


def _chosen(trace: Trace, patterns: Sequence[str], *, bits: bool) -> Sequence[str]:
    """Return the patterns, or with `bits`, the names of the bits among the signals that match."""
    if not bits:
        return patterns
    signals = Catalog.of(trace).matching(patterns)
    names = [signal.name for signal in signals if signal.kind is SignalKind.BIT]
    if not names:
        raise ValueError(f"--bits: no signal of {' '.join(patterns)} is a bit")
    return names


def _check(outputs: Sequence[tuple[ExportFormat, Path]], trace: Path, *, choice: str) -> None:
    """Raise ValueError if an output can't be written to its target.

    Args:
        choice: the option that chooses signals; "" without one.
    """
    if choice and not any(export_format.selects_signals for export_format, _ in outputs):
        raise ValueError(f"{choice}: not possible for a copy as MCAP, which has the whole trace")
    if not outputs:
        options = ", ".join(export_format.option for export_format in formats.FORMATS)
        raise ValueError(f"no output: give one or more of {options}")
    if sum(target == STDOUT for _, target in outputs) > 1:
        raise ValueError("only one output can go to standard output")
    for format_, target in outputs:
        if target != STDOUT:
            check_output(target, format_.kind, itself(trace))


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("export", no_args_is_help=True)(grouped(_export_command, targets=_targets()))
