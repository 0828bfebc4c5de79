"""`scanrack import CAPTURE`: convert a network capture or a frame log to a trace."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer
from scanrack.io_images.enip.codes import PORT
from scanrack.jobs.captures.cip_words import cip_scans
from scanrack.jobs.captures.modeling import simulated
from scanrack.jobs.captures.reading import MODBUS_PORT, pairing_of, read_capture
from scanrack.jobs.captures.recording import record, statements_of, value_names
from scanrack.jobs.captures.words import record_words, word_scans
from scanrack.terminal.complaints import reported_mistakes
from scanrack.terminal.grouped import grouped
from scanrack.terminal.shared_options import QuietOption
from scanrack.terminal.status import DONE, complain
from scanrack.terminal.terminal import say
from scanrack.traces.files.guard import TRACE, check_output


class CapturedController(StrEnum):
    """Controllers whose captures can be imported."""

    AMCI3601 = "amci3601"
    PCL601 = "pcl601"
    PMC006 = "pmc006"
    COMPACTLOGIX = "compactlogix"


@dataclass(frozen=True, slots=True, kw_only=True)
class ImportOptions:
    """The argument and the options of `scanrack import`."""

    capture: Annotated[
        Path,
        typer.Argument(
            metavar="CAPTURE", help="A capture (pcap or pcapng), or a log of frames.", show_default=False
        ),
    ]
    controller: Annotated[
        CapturedController,
        typer.Option("--as", metavar="CONTROLLER", help="amci3601, pcl601, pmc006 or compactlogix."),
    ] = CapturedController.PCL601
    unit: Annotated[
        int | None,
        typer.Option(
            "--address",
            metavar="N",
            help="Address of the controller, if the capture has several; for compactlogix, the slot.",
            min=0,
            max=255,
        ),
    ] = None
    port: Annotated[
        int | None,
        typer.Option(
            "--port",
            metavar="PORT",
            help="TCP port of the controller or gateway.",
            min=1,
            max=65535,
            show_default=f"{MODBUS_PORT}; compactlogix: {PORT}",
        ),
    ] = None
    rtu_over_tcp: Annotated[
        bool,
        typer.Option("--rtu-over-tcp", help="Raw serial bytes over TCP; implied for a log and a PMC006."),
    ] = False
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="FILE", help="Trace file.", show_default="CAPTURE with .mcap"),
    ] = None
    simulated_to: Annotated[
        Path | None,
        typer.Option(
            "--simulated",
            metavar="FILE",
            help="Also record the simulated device's responses.",
        ),
    ] = None
    quiet: QuietOption = False


def _import_command(
    options: ImportOptions,
) -> None:
    """Convert a network capture to a trace, for show, query, plot, export and compare.

    Each exchange becomes a scan, at the time of its reply. Registers become tags. With --simulated, the same
    requests go to a simulated controller; compare both traces to find where the real controller differs.
    For a 3601 as remote I/O, or in a CompactLogix from which a client reads Local:1:I and Local:1:O over
    EtherNet/IP, a scan is a read of the input words, and `scanrack replay` replays them.

    Examples:
        scanrack import line.pcapng --as pcl601 --address 1 --simulated model.mcap

    Exit status: 0 converted, 2 a file or option can't be used, 3 a trace can't be written.
    """
    with reported_mistakes():
        has_words = options.controller in (CapturedController.AMCI3601, CapturedController.COMPACTLOGIX)
        if has_words and options.simulated_to is not None:
            raise ValueError("--simulated does not apply to an amci3601: use scanrack replay")
        target = options.out or Path(options.capture.name).with_suffix(".mcap")
        outputs = [target] if options.simulated_to is None else [target, options.simulated_to]
        files_in_use = {options.capture: "the capture"}
        for output in outputs:
            check_output(output, TRACE, files_in_use)
            files_in_use[output] = "the other trace"
        over_enip = options.controller is CapturedController.COMPACTLOGIX
        tcp_port = options.port or (PORT if over_enip else MODBUS_PORT)
        capture = read_capture(
            options.capture, pairing_of(options.controller, rtu=options.rtu_over_tcp), tcp_port, options.unit
        )
        _report(capture.notes, quiet=options.quiet)  # first, since notes may explain an error
        if has_words:
            scans, notes = cip_scans(capture.exchanges) if over_enip else (word_scans(capture.exchanges), [])
            first = capture.exchanges[0]
            record_words(target, scans, first.requested_ns, first.unit if over_enip else 1, sampled=over_enip)
            _report(notes, f"{target}: {len(scans):,} scans of a PLC", quiet=options.quiet)
            raise typer.Exit(DONE)
        real = statements_of(options.controller, capture.exchanges)
        model = [] if options.simulated_to is None else simulated(options.controller, real)
        names = value_names(real, model)
        record(target, options.controller, real, names)
        if options.simulated_to is not None:
            record(options.simulated_to, options.controller, model, names)
        unit = capture.exchanges[0].unit
        _report([], f"{target}: {len(real):,} exchanges with unit {unit}", quiet=options.quiet)
    raise typer.Exit(DONE)


def _report(notes: list[str], summary: str = "", *, quiet: bool) -> None:
    if not quiet:
        for note in notes:
            complain(f"note: {note}")
        if summary:
            say(summary)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("import", no_args_is_help=True)(grouped(_import_command, options=ImportOptions))
