"""`scanrack import CAPTURE`: a capture of a network, or a log of frames, as a trace."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from ...io_images.enip.codes import PORT
from ...jobs.captures.cip_words import cip_scans
from ...jobs.captures.modelling import simulated
from ...jobs.captures.reading import MODBUS_PORT, pairing_of, read_capture
from ...jobs.captures.recording import record, said_by, value_names
from ...jobs.captures.words import record_words, word_scans
from ...terminal.complaints import reported_mistakes
from ...terminal.status import DONE, complain
from ...terminal.terminal import say
from ...terminal.trace_options import QuietOption
from ...traces.files.guard import TRACE, check_output


class CapturedController(StrEnum):
    """Controllers whose exchanges are understood."""

    AMCI3601 = "amci3601"
    PCL601 = "pcl601"
    PMC006 = "pmc006"
    COMPACTLOGIX = "compactlogix"


def _import_command(
    capture: Annotated[
        Path, typer.Argument(help="A capture, pcap or pcapng, or a log of frames.", show_default=False)
    ],
    controller: Annotated[
        CapturedController,
        typer.Option("--as", metavar="CONTROLLER", help="amci3601, pcl601, pmc006 or compactlogix."),
    ] = CapturedController.PCL601,
    unit: Annotated[
        int | None,
        typer.Option(
            "--unit", help="Its address, if there are several; the slot in a compactlogix.", min=0, max=255
        ),
    ] = None,
    port: Annotated[
        int | None,
        typer.Option(
            "--port",
            help="TCP port of the controller or gateway.",
            min=1,
            max=65535,
            show_default=f"{MODBUS_PORT}; compactlogix: {PORT}",
        ),
    ] = None,
    rtu_over_tcp: Annotated[
        bool, typer.Option("--rtu-over-tcp", help="Bytes of the line; as always with a log and a PMC006.")
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="FILE", help="Where to.", show_default="CAPTURE with .mcap"),
    ] = None,
    simulated_to: Annotated[
        Path | None,
        typer.Option(
            "--simulated",
            metavar="FILE",
            help="Also write what a simulated one answers to the same.",
        ),
    ] = None,
    quiet: QuietOption = False,
) -> None:
    """Make a trace of what a real controller said, for show, query, plot, export and compare.

    A scan is an exchange, at the time of its reply. Registers are tags by their names. With --simulated the
    same requests go to a simulated controller: compare the two traces to see where the real one differs.
    Of a 3601 as remote I/O a scan is a read of its input words: replay gives them to a simulated one. So it
    is of one in a CompactLogix, whose Local:1:I and Local:1:O some client reads over EtherNet/IP.

    Example: scanrack import line.pcapng --as pcl601 --unit 1 --simulated model.mcap

    Exit status: 0 done, 2 a file or option can't be used, 3 a trace can't be written.
    """
    with reported_mistakes():
        has_words = controller in (CapturedController.AMCI3601, CapturedController.COMPACTLOGIX)
        if has_words and simulated_to is not None:
            raise ValueError("--simulated: the words of an amci3601 are for scanrack replay")
        target = out or Path(capture.name).with_suffix(".mcap")
        outputs = [target] if simulated_to is None else [target, simulated_to]
        used = {capture: "the capture"}
        for each in outputs:
            check_output(each, TRACE, used)
            used[each] = "the other trace"
        over_enip = controller is CapturedController.COMPACTLOGIX
        port = port or (PORT if over_enip else MODBUS_PORT)
        found = read_capture(capture, pairing_of(controller, rtu=rtu_over_tcp), port, unit)
        if has_words:
            scans, notes = cip_scans(found.exchanges) if over_enip else (word_scans(found.exchanges), [])
            first = found.exchanges[0]
            record_words(target, scans, first.asked_ns, first.unit if over_enip else 1)
            found.notes += notes
            _tell(found.notes, f"{target}: {len(scans):,} scans of a PLC", quiet=quiet)
            raise typer.Exit(DONE)
        real = said_by(controller, found.exchanges)
        model = [] if simulated_to is None else simulated(controller, real)
        names = value_names(real, model)
        record(target, controller, real, names)
        if simulated_to is not None:
            record(simulated_to, controller, model, names)
        done = f"{target}: {len(real):,} exchanges with unit {found.exchanges[0].unit}"
        _tell(found.notes, done, quiet=quiet)
    raise typer.Exit(DONE)


def _tell(notes: list[str], done: str, *, quiet: bool) -> None:
    if not quiet:
        for note in notes:
            complain(f"note: {note}")
        say(done)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("import", no_args_is_help=True)(_import_command)
