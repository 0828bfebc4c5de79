"""The commands; the only place that knows all the rooms.

A command's module is imported when the command is used: a run does not wait for the fuzzer's libraries.
"""

from __future__ import annotations

import difflib
import re
import sys
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module
from typing import Any, NamedTuple

import typer
from typer.core import TyperGroup

from ..runtime.loop.pace import ending_as_interrupt, interrupted_by
from ..terminal.ending import end_in_time
from ..terminal.limiting import limit_traces
from ..terminal.status import BAD_INPUT, INTERRUPTED, PIPE_CLOSED, complain, reason
from ..terminal.streams import LostOutput, closed_streams_plugged, guarded_output
from ..terminal.terminal import say

__all__ = ["build", "main"]


class Entry(NamedTuple):
    """A line of `scanrack --help`."""

    module: str  # of the command, relative to this package; it has `register(app)`
    sentence: str


UsageMistake: type[Exception] = typer.BadParameter.__mro__[2]
"""The parser's error for unusable words; Typer exports only a subclass."""

COMMANDS = {
    "new": Entry(".programs.new", "Begin a project: a rack, a program and a test."),
    "run": Entry(".programs.run", "Run a rack's logic scan by scan, and record every scan."),
    "watch": Entry("..watch.command", "Show a rack that runs, or a trace, in the browser."),
    "share": Entry("..watch.share.command", "Write a trace and its page to one file."),
    "show": Entry(".recordings.show", "Print a trace: what happened, and what changed."),
    "query": Entry(".recordings.query", "Find the scans of a trace in which something holds."),
    "plot": Entry(".recordings.plot", "Draw a timing chart of a trace."),
    "export": Entry(".recordings.export", "Write a trace as CSV, Parquet or VCD."),
    "compare": Entry(".recordings.compare", "Compare two traces."),
    "import": Entry(".recordings.imports", "Make a trace of a capture of a real controller."),
    "repair": Entry(".recordings.repair", "Complete a trace that was killed or damaged."),
    "replay": Entry(".recordings.replay", "Replay a trace into a module, a program or a rack."),
    "rerun": Entry(".recordings.rerun", "Run again what a trace was made by."),
    "ladder": Entry(".programs.ladder", "Draw the rungs of a ladder program."),
    "l5x": Entry(".programs.l5x", "Say what an exported controller has, what runs, and what does not."),
    "why": Entry(".programs.why", "Say why a tag is as it is."),
    "xref": Entry(".programs.why", "List where tags are read and written."),
    "prove": Entry(".programs.prove", "Prove properties of a ladder program, or find what breaks them."),
    "fuzz": Entry(".programs.fuzz", "Look for surroundings that break a program."),
    "drive": Entry(".wire.drive", "Put one module or controller on the bench."),
    "conform": Entry(".wire.conform", "Hold a real 3601 against the manual."),
    "serve": Entry(".wire.serve", "Serve a simulated controller at a port."),
    "pcl601": Entry(".wire.pcl601", "Talk to a PCL601 on a serial port or a network."),
    "pmc006": Entry(".wire.pmc006", "Talk to a PMC006 on a serial port."),
    "ports": Entry(".wire.discovery", "List the serial devices of this machine."),
    "probe": Entry(".wire.discovery", "Say what controller answers on a port."),
    "pclt": Entry(".wire.pclt", "Check and list stored programs of the PCL601."),
    "check": Entry(".programs.check", "Check a rack without running it."),
    "schema": Entry(".programs.schema", "Print the JSON Schema of rack files, for editors."),
    "lsp": Entry("..lsp.command", "Serve an editor: mistakes at their lines, meaning, completion."),
    "doctor": Entry(".programs.doctor", "Say what this installation has, what it lacks, and how to mend it."),
    "rules": Entry(".programs.rules", "Print the rules of a module's manual."),
}
"""The commands in the order of --help."""


class Lazy(TyperGroup):
    """A group that imports a command's module when the command is requested."""

    _command_first = False  # there are no options before the command

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the words before the command, if there are any."""
        self._command_first = bool(args) and args[0] in COMMANDS
        return super().parse_args(ctx, args)

    def get_params(self, ctx: Any) -> list[Any]:
        """Return the options before the command; none if it comes first.

        Typer checks even their defaults, for which it imports pydantic: a third of the time of `run --help`.
        """
        return [] if self._command_first else super().get_params(ctx)

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names of all commands."""
        return list(COMMANDS)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a command; refuse an unknown name with the closest one."""
        entry = COMMANDS.get(cmd_name)
        if entry is None:
            return ctx.fail(_unknown(cmd_name))
        app = _application(TyperGroup)
        import_module(entry.module, __package__).register(app)
        return typer.main.get_group(app).commands[cmd_name]

    def main(
        self, args: Sequence[str] | None = None, prog_name: str | None = None, *_: Any, **options: Any
    ) -> Any:
        """Parse words and run a command; unusable options give a one-line message and a status.

        Raises:
            SystemExit: always, with a status of `terminal.status`.
        """
        words = sys.argv[1:] if args is None else list(args)
        options["standalone_mode"] = False
        try:
            sys.exit(super().main(words, prog_name, **options))
        except UsageMistake as error:
            if type(error).__name__ == "NoArgsIsHelpError":  # the page of the command, which takes words
                say(error, err=True)
                sys.exit(BAD_INPUT)
            sys.exit(complain(_usage(error, words), BAD_INPUT))

    def invoke(self, ctx: Any) -> Any:
        """Run a command; a signal that ends the process interrupts it, with one message.

        Commands with unfinished work, such as a trace, complete it on their way out.
        """
        with ending_as_interrupt():
            try:
                return super().invoke(ctx)
            except KeyboardInterrupt:
                raise typer.Exit(complain(f"stopped by {interrupted_by()}", INTERRUPTED)) from None

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """List the commands without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, entry.sentence) for name, entry in COMMANDS.items()])


def _unknown(name: str) -> str:
    close = difflib.get_close_matches(name, COMMANDS, n=1)
    meant = f"did you mean {close[0]}?" if close else f"there are {', '.join(COMMANDS)}"
    return f"there is no command {name!r}: {meant}"


SPEECH = (
    ("Value error, ", ""),
    (r"^Invalid value for '?(.+?)'?: ", r"\1: "),
    ("Input should be a valid integer.*", "a whole number is needed"),
    ("Input should be a valid number.*", "a number is needed"),
    (r"Input should be greater than or equal to (\S+)", r"\1 or more is allowed"),
    (r"Input should be less than or equal to (\S+)", r"\1 or less is allowed"),
)
"""Patterns of the libraries' sentences, and their replacements."""


def _usage(error: Any, words: Sequence[str]) -> str:
    """Return the mistake in the words of a command, and the command that prints its page."""
    said = error.format_message().rstrip(".")
    for theirs, ours in SPEECH:
        said = re.sub(theirs, ours, said)
    option, possible = getattr(error, "option_name", ""), getattr(error, "possibilities", None)
    if possible:
        said = f"no such option: {option}; did you mean {' or '.join(sorted(possible))}?"
    path = error.ctx.command_path if error.ctx else "scanrack"
    number = next((word for word in words if option and word.startswith(option)), "")
    if re.fullmatch(r"-\d.*", number):
        said = f"{number} looks like an option; put -- before a negative number: {path} -- {number}"
    return f"{said[:1].lower()}{said[1:]} ('{path} --help' lists what there is)"


def build() -> typer.Typer:
    """Return the command-line application."""
    return _application(Lazy)


def _application(group: type[TyperGroup]) -> typer.Typer:
    """Return an application without commands; a callback makes it a group even of one."""
    app = typer.Typer(
        name="scanrack",
        cls=group,
        help="A PLC rack in software for stepper controllers.\n\n"
        "Run your logic scan by scan against a simulated AMCI 3601 bolted to a simulated machine; "
        "every scan is recorded.",
        no_args_is_help=True,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.callback()(limit_traces)
    return app


def main() -> None:
    """Run the `scanrack` command; print at most one message, whatever ends it.

    Raises:
        SystemExit: always, with a status of `terminal.status`.
    """
    try:
        _main()
    except SystemExit as end:
        end_in_time(end.code)
        raise


def _main() -> None:
    closed_streams_plugged()
    try:
        with guarded_output():
            _run()
    except LostOutput as lost:
        if lost.status != PIPE_CLOSED:
            with suppress(OSError):  # standard error may be full, too
                complain(f"standard output can't be written: {lost.error.strerror}")
        sys.exit(lost.status)


def _run() -> None:
    """Run the command; report an error of a file that no command handles."""
    try:
        build()()
    except OSError as error:
        sys.exit(complain(reason(error), BAD_INPUT))
