"""The page of commands, docs/commands.md, from the commands: each with its arguments and options."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import typer
from scanrack.commands import build

PAGE = Path(__file__).parents[2] / "docs/commands.md"
REMEDY = "python -m tests.tools.generate commands"
INTRO = """\
# Commands and their options

What `scanrack COMMAND --help` lists, on one page. The pages that [the contents](index.md) name say what
each command is for. `-h` is `--help`. A negative number goes after `--`:
`scanrack device pcl601 move -- -100`.
`python -m tests.tools.generate` makes this page from the commands; don't edit it.

## Exit statuses

| | of every command | of `run` |
|--:|---|---|
| 0 | done; the answer is yes | done |
| 1 | the answer is no: it differs, nothing was found, something broke | the controller faulted |
| 2 | a file, a key or an option can't be used | the same |
| 3 | a file or standard output can't be written | the disk is full; a server never began |
| 130 | Ctrl-C, SIGTERM or SIGHUP | the same |
| 141 | the reader of standard output has gone, as after `\\| head -1`; no message | the same |

In every case there is one message, on standard error, and the trace is whole up to
there. Threads of the program that continue after that, and are not daemons, are named and ended after 2 s.
"""


def commands(group: Any, path: str = "scanrack") -> Iterator[tuple[str, Any]]:
    """Yield the words of each command, and the command."""
    context = typer.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        words = f"{path} {name}"
        if hasattr(command, "list_commands"):
            yield from commands(command, words)
        else:
            yield words, command


def chain(group: Any, words: Sequence[str]) -> list[Any]:
    """Return the commands that words name, each within the one before; further words are left out."""
    found: list[Any] = []
    for word in words:
        within = group.get_command(typer.Context(group), word) if hasattr(group, "list_commands") else None
        if within is None:
            break
        found.append(group := within)
    return found


def lines() -> Iterator[str]:
    """Yield the lines of all commands: a heading, and a row for each argument and option."""
    for words, command in commands(typer.main.get_command(build())):
        arguments = [each for each in command.params if each.param_type_name == "argument"]
        names = [each.metavar or each.name.upper() for each in arguments]
        yield from (
            "",
            f"## {' '.join([words, *names])}",
            "",
            "| option | meaning | if left out |",
            "|---|---|---|",
        )
        for parameter in command.params:
            if parameter.param_type_name == "option":
                yield f"| {spelled(parameter)} | {cell(parameter.help or '')} | {left_out(parameter)} |"


def spelled(option: Any) -> str:
    """Return the names of an option, with the word that it takes."""
    takes = f" {option.metavar}" if option.metavar else ""
    return cell(", ".join(f"`{name}{takes}`" for name in (*option.opts, *option.secondary_opts)))


def left_out(option: Any) -> str:
    """Return what holds without the option; a flag that is off needs no word."""
    if isinstance(option.show_default, str):
        return cell(option.show_default)
    default = getattr(option.default, "value", option.default)
    return (
        "" if option.show_default is False or default in (None, False, "", (), []) else cell(f"`{default}`")
    )


def cell(text: str) -> str:
    return re.sub(r"\s+", " ", text).strip().replace("|", "\\|")


def page() -> str:
    """Return the page as it should be."""
    return INTRO + "\n".join(lines()) + "\n"


def missing(text: str) -> list[str]:
    """Return the lines in which a page differs, each with its command."""
    ours, theirs = (named(each) for each in (page(), text))
    return [f"missing: {each}" for each in ours if each not in theirs] + [
        f"of no command: {each}" for each in theirs if each not in ours
    ]


def named(text: str) -> list[str]:
    """Return the rows of a page, each after its command."""
    sections = (part.splitlines() for part in text.split("\n## ")[1:])
    return [
        f"{head}: {row}" for head, *rows in sections for row in ["", *rows] if not row or row[:3] == "| `"
    ]
