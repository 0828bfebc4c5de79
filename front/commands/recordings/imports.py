"""`scanrack import CAPTURE`: a capture of a network, or a log of frames, as a trace."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from ...jobs.captures.modelling import simulated
from ...jobs.captures.reading import MODBUS_PORT, pairing_of, read_capture
from ...jobs.captures.recording import record, said_by, value_names
from ...terminal.complaints import reported_mistakes
from ...terminal.status import DONE, complain
from ...terminal.terminal import say
from ...terminal.trace_options import QuietOption
from ...traces.files.guard import TRACE, check_output


class CapturedController(StrEnum):
    """Controllers whose exchanges are understood."""

    PCL601 = "pcl601"
    PMC006 = "pmc006"


def _import_command(
    capture: Annotated[
        Path, typer.Argument(help="A capture, pcap or pcapng, or a log of frames.", show_default=False)
    ],
    controller: Annotated[
        CapturedController, typer.Option("--as", metavar="CONTROLLER", help="pcl601 or pmc006.")
    ] = CapturedController.PCL601,
    unit: Annotated[
        int | None, typer.Option("--unit", help="Its address, if there are several.", min=0, max=255)
    ] = None,
    port: Annotated[
        int, typer.Option("--port", help="TCP port of the controller or gateway.", min=1, max=65535)
    ] = MODBUS_PORT,
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

    Example: scanrack import line.pcapng --as pcl601 --unit 1 --simulated model.mcap

    Exit status: 0 done, 2 a file or option can't be used, 3 a trace can't be written.
    """
    with reported_mistakes():
        target = out or Path(capture.name).with_suffix(".mcap")
        outputs = [target] if simulated_to is None else [target, simulated_to]
        used = {capture: "the capture"}
        for each in outputs:
            check_output(each, TRACE, used)
            used[each] = "the other trace"
        found = read_capture(capture, pairing_of(controller, rtu=rtu_over_tcp), port, unit)
        real = said_by(controller, found.exchanges)
        model = [] if simulated_to is None else simulated(controller, real)
        names = value_names(real, model)
        record(target, controller, real, names)
        if simulated_to is not None:
            record(simulated_to, controller, model, names)
        for note in () if quiet else found.notes:
            complain(f"note: {note}")
        if not quiet:
            say(f"{target}: {len(real):,} exchanges with unit {found.exchanges[0].unit}")
    raise typer.Exit(DONE)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("import", no_args_is_help=True)(_import_command)
