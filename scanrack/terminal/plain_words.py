"""Reads plain words of a command without typer, whose import takes longer than many commands.

Typer reads all other words, and reports all mistakes.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

TEXT = r"[^-].*"


class Value(NamedTuple):
    """An option that takes a word."""

    name: str  # of its argument
    kind: Callable[[str], Any] = str
    pattern: str = TEXT  # of a plain word


class PlainWords(NamedTuple):
    """The arguments of a command, and its plain options, by name."""

    needed: Sequence[str]
    further: Sequence[str] = ()  # arguments that may be left out
    flags: Mapping[str, str] = {}  # options that take no word
    values: Mapping[str, Value] = {}

    def read(self, words: Sequence[str]) -> dict[str, Any] | None:
        """Return the arguments by name; None if the words are not plain, right or wrong.

        >>> words = PlainWords(["file"], flags={"-q": "quiet"}, values={"--scans": Value("scans", int)})
        >>> words.read(["a.toml", "--scans", "3", "-q"])
        {'file': 'a.toml', 'scans': 3, 'quiet': True}
        >>> words.read(["a.toml", "--scans=3"]), words.read(["a.toml", "-q", "-q"])
        (None, None)
        """
        arguments: dict[str, Any] = {}
        places, remaining = iter((*self.needed, *self.further)), iter(words)
        for word in remaining:
            name, value = self._meaning(word, places, remaining)
            if not name or name in arguments:
                return None
            arguments[name] = value
        return arguments if arguments.keys() >= {*self.needed} else None

    def _meaning(self, word: str, places: Iterator[str], rest: Iterator[str]) -> tuple[str, Any]:
        """Return name and value of an argument; no name for a word that is not plain."""
        if word in self.values:
            name, kind, pattern = self.values[word]
            text = next(rest, "")
            return (name, kind(text)) if re.fullmatch(pattern, text, re.ASCII | re.DOTALL) else ("", None)
        if word in self.flags:
            return self.flags[word], True
        return (next(places, ""), word) if re.fullmatch(TEXT, word, re.DOTALL) else ("", None)
