"""`scanrack why RACK|TRACE [WHAT]`: its plain words, without typer."""

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
    """Answer a question if the words after `why` are plain; return False if they are not.

    Raises:
        SystemExit: the question has an answer, or none.
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
