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
        str, typer.Argument(metavar="RACK|TRACE", help="A rack file, or the trace of a run or a scenario.")
    ]
    what: Annotated[
        str | None,
        typer.Argument(
            metavar="[WHAT]",
            help="A tag (Run, Fill.DN), a bit or word of an image (slot1.command.HOLD_MOVE, O:1.2), or a "
            "value of a Python program (line.step). Without it: the wait of every module.",
        ),
    ] = None
    at: Annotated[
        str | None,
        typer.Option(
            "--at", metavar="TIME|SCAN", help="Time or scan of the question, such as '1.5 s' or 750."
        ),
    ] = None
    until: Annotated[
        str | None, typer.Option("--until", metavar="BIT", help="Ask as soon as this tag or bit is on.")
    ] = None
    deep: Annotated[
        bool,
        typer.Option("--deep", help="Show the whole chain of causes; include Add-On Instruction rungs."),
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
