"""The typer command line, with options, help and reworded error messages.

A command's module is imported when the command is used, so that a run does not wait for the fuzzer's
libraries.
"""

from __future__ import annotations

import difflib
import re
import sys
from collections.abc import Sequence
from functools import cache
from importlib import import_module
from typing import Any

import typer
from scanrack.terminal.interrupting import interrupted
from scanrack.terminal.limiting import limit_traces
from scanrack.terminal.status import BAD_INPUT, complain
from scanrack.terminal.terminal import say
from typer.core import TyperGroup

from .catalog import COMMANDS, GROUPS


class Lazy(TyperGroup):
    """A group that imports a command's module when the command is requested."""

    _command_first = False  # whether the command line has no options before the command

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the words that precede the command."""
        self._command_first = bool(args) and args[0] in COMMANDS
        return super().parse_args(ctx, args)

    def get_params(self, ctx: Any) -> list[Any]:
        """Return the options that may precede the command, or none if the command comes first.

        To check even their defaults, Typer imports pydantic, a third of the time of `run --help`.
        """
        return [] if self._command_first else super().get_params(ctx)

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names of all commands."""
        return list(COMMANDS)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a command; refuse an unknown name, and suggest the closest one."""
        return _command(cmd_name) if cmd_name in COMMANDS else ctx.fail(_unknown(cmd_name))

    def main(
        self, args: Sequence[str] | None = None, prog_name: str | None = None, *_: Any, **options: Any
    ) -> Any:
        """Parse words and run a command; unusable options cause a one-line message and an exit status.

        Raises:
            SystemExit: always, with a status of `terminal.status`.
        """
        words = sys.argv[1:] if args is None else list(args)
        options["standalone_mode"] = False
        try:
            sys.exit(super().main(words, prog_name, **options))
        except typer.TyperException as error:
            if type(error).__name__ == "NoArgsIsHelpError":  # the help of a command that needs arguments
                say(error, err=True)
                sys.exit(BAD_INPUT)
            sys.exit(complain(_usage(error, words), BAD_INPUT))

    def invoke(self, ctx: Any) -> Any:
        """Run a command."""
        with interrupted():
            return super().invoke(ctx)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """List the commands without importing them."""
        width = max(map(len, COMMANDS))
        for heading, group in GROUPS.items():
            with formatter.section(heading):
                formatter.write_dl([(name.ljust(width), entry.sentence) for name, entry in group.items()])


@cache
def _command(name: str) -> Any:
    app = _application(TyperGroup)
    import_module(COMMANDS[name].module, __package__).register(app)
    return _plain(typer.main.get_group(app).commands[name])


def _plain(command: Any) -> Any:
    """Simplify the help of a command and its subcommands; return the command.

    Some versions of Typer write `{RACK}` for required arguments, `[[WHAT]]` for optional ones, and the Python
    type after an argument's name. Typer rewraps a paragraph of examples, unless a backspace precedes it.
    """
    command.help = re.sub(r"^Examples:$", "\b\n\\g<0>", command.help or "", flags=re.MULTILINE)
    for parameter in command.params:
        if parameter.param_type_name == "argument":
            parameter.display_type = lambda _: ""
    pieces = command.collect_usage_pieces
    command.collect_usage_pieces = lambda context: [
        re.sub(r"^(?:\{(.+)\}|\[(\[.+\])\])(?:\.\.\.)?$", r"\1\2", piece) for piece in pieces(context)
    ]
    for subcommand in getattr(command, "commands", {}).values():
        _plain(subcommand)
    return command


def _unknown(name: str) -> str:
    matches = difflib.get_close_matches(name, COMMANDS, n=1)
    hint = f": did you mean {matches[0]}?" if matches else f"; choose from {', '.join(COMMANDS)}"
    return f"no command {name!r}{hint}"


REPLACEMENTS = (
    ("Value error, ", ""),
    (r"^Invalid value for '?(.+?)'?: ", r"\1: "),
    ("Input should be a valid integer.*", "a whole number is needed"),
    ("Input should be a valid number.*", "a number is needed"),
    (r"Input should be greater than or equal to (\S+)", r"\1 or more is allowed"),
    (r"Input should be less than or equal to (\S+)", r"\1 or less is allowed"),
)
"""Patterns in library messages, and their replacements."""


INTENDED = {("run", "--trace"): "--record", ("watch", "--trace"): "--record"}
"""The correct option for each wrong name that users try, by command and wrong name."""


def _reworded(text: str) -> str:
    for pattern, replacement in REPLACEMENTS:
        text = re.sub(pattern, replacement, text)
    return text


def _usage(error: Any, words: Sequence[str]) -> str:
    """Return a message with the error in a command line and the command that prints the help."""
    text = _reworded(error.format_message().rstrip("."))
    option, suggestions = getattr(error, "option_name", ""), getattr(error, "possibilities", None)
    path, command = (error.ctx.command_path, error.ctx.info_name) if error.ctx else ("scanrack", "")
    if (command, option) in INTENDED:
        suggestions = [INTENDED[command, option]]
    if suggestions:
        text = f"no such option: {option}; did you mean {' or '.join(sorted(suggestions))}?"
    word = next((word for word in words if option and word.startswith(option)), "")
    if re.fullmatch(r"-\d.*", word):
        text = f"{word} looks like an option; put -- before a negative number: {path} -- {word}"
    text = text if text[:2].isupper() else f"{text[:1].lower()}{text[1:]}"
    return f"{text} ('{path} --help' lists what there is)"


def application() -> typer.Typer:
    """Return the command-line application."""
    return _application(Lazy)


def _application(group: type[TyperGroup]) -> typer.Typer:
    """Return an application without commands; its callback makes it a group even with only one command."""
    app = typer.Typer(
        name="scanrack",
        cls=group,
        help="A PLC rack in software for stepper controllers.\n\n"
        "Run your logic scan by scan against a simulated AMCI 3601 on a simulated machine. "
        "Every scan is recorded.",
        no_args_is_help=True,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.callback()(limit_traces)
    return app
