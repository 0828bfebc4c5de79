"""`scanrack why RACK|TRACE [WHAT]`, parsed without typer for simple command lines."""

from __future__ import annotations

from collections.abc import Sequence

from scanrack.terminal.importing import imported
from scanrack.terminal.plain_words import PlainWords, Value

from .why_arguments import WhyArguments

WORDS = PlainWords(
    ["file"],
    ["what"],
    flags={"--deep": "deep", "--json": "as_json"},
    values={"--at": Value("at"), "--until": Value("until"), "--want": Value("want")},
)


def plain_why(words: Sequence[str]) -> bool:
    """Answer a question; return False if only typer can parse the words after `why`.

    Raises:
        SystemExit: the command has ended.
    """
    arguments = WORDS.read(words)
    if arguments is None:
        return False
    why_command(WhyArguments(**arguments))
    raise SystemExit


def why_command(options: WhyArguments) -> None:
    """Answer a question; see `why_job.why`."""
    with imported():
        from .why_job import why

    why(options)
