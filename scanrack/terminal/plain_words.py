"""Parses simple command lines without typer, whose import takes longer than many commands.

Typer parses all other command lines, and reports all errors.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

TEXT = r"[^-].*"


class Value(NamedTuple):
    """An option with a value."""

    name: str  # of its argument
    kind: Callable[[str], Any] = str  # converts the word
    pattern: str = TEXT  # of a plain word


class PlainWords(NamedTuple):
    """The arguments of a command, and its plain options, by name."""

    needed: Sequence[str]
    further: Sequence[str] = ()  # arguments that may be left out
    flags: Mapping[str, str] = {}  # options without a value
    values: Mapping[str, Value] = {}

    def read(self, words: Sequence[str]) -> dict[str, Any] | None:
        """Return the arguments by name; None for words that only typer can parse.

        >>> words = PlainWords(["file"], flags={"-q": "quiet"}, values={"--scans": Value("scans", int)})
        >>> words.read(["a.toml", "--scans", "3", "-q"])
        {'file': 'a.toml', 'scans': 3, 'quiet': True}
        >>> words.read(["a.toml", "--scans=3"]), words.read(["a.toml", "-q", "-q"])
        (None, None)
        """
        arguments: dict[str, Any] = {}
        names, remaining = iter((*self.needed, *self.further)), iter(words)
        for word in remaining:
            name, value = self._meaning(word, names, remaining)
            if not name or name in arguments:
                return None
            arguments[name] = value
        return arguments if arguments.keys() >= {*self.needed} else None

    def _meaning(self, word: str, names: Iterator[str], remaining: Iterator[str]) -> tuple[str, Any]:
        """Return the name and the value of an argument; the name is "" for a word that is not plain.

        Args:
            names: names of the next arguments without an option.
            remaining: the words after this one.
        """
        if word in self.values:
            name, kind, pattern = self.values[word]
            text = next(remaining, "")
            return (name, kind(text)) if re.fullmatch(pattern, text, re.ASCII | re.DOTALL) else ("", None)
        if word in self.flags:
            return self.flags[word], True
        return (next(names, ""), word) if re.fullmatch(TEXT, word, re.DOTALL) else ("", None)
