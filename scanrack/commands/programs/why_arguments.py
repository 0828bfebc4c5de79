"""The arguments of `scanrack why`, without typer."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from scanrack.io_images.dataclass import dataclass

if TYPE_CHECKING:  # `grouped` resolves the annotations only if typer reads the words
    import typer
    from scanrack.terminal.as_json import JsonOption
    from scanrack.terminal.shared_options import TrustOption


@dataclass(frozen=True, slots=True, kw_only=True)
class WhyArguments:
    """The arguments and the options of `scanrack why`."""

    file: Annotated[
        str, typer.Argument(metavar="RACK|TRACE", help="A rack file, or a trace of a run, or of a scenario.")
    ]
    what: Annotated[
        str | None,
        typer.Argument(
            metavar="[WHAT]",
            help="A tag (Run, Fill.DN), a bit or word of an image (slot1.command.HOLD_MOVE, O:1.2), or a "
            "value of a Python program (line.step). Left out: what every module waits for.",
        ),
    ] = None
    at: Annotated[
        str | None,
        typer.Option("--at", metavar="TIME|SCAN", help="Ask at this time, such as '1.5 s', or in this scan."),
    ] = None
    until: Annotated[
        str | None, typer.Option("--until", metavar="BIT", help="Ask when this tag or bit of an image is on.")
    ] = None
    deep: Annotated[
        bool,
        typer.Option("--deep", help="Show the whole chain of causes, also inside of add-on instructions."),
    ] = False
    want: Annotated[
        str | None,
        typer.Option(
            "--want",
            metavar="VALUE",
            help="Also show how the tag can get this value: on, off or a number.",
        ),
    ] = None
    trust: TrustOption = False
    as_json: JsonOption = False
