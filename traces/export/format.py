"""An export format. Each format's module defines one as `FORMAT`; `formats` lists them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from ..files.guard import FileKind


@dataclass(frozen=True, slots=True, kw_only=True)
class ExportFormat:
    """An export format, from which `scanrack export` derives its option and its documentation.

    Attributes:
        name: name of its option, letters: "csv" is `--csv OUT`.
        kind: the kind of its files; a file of another kind is not replaced.
        write: writes a trace, see `write_csv`; has no parameter `signals` unless `selects_signals`.
        help: help text of the option.
        contents: contents of the file, for docs/query.md.
        reader: programs that read it, for docs/query.md.
        binary: whether the file and standard output need bytes instead of text.
        selects_signals: whether the user can select signals.
    """

    name: str
    kind: FileKind
    write: Callable[..., int]
    help: str
    contents: str
    reader: str
    binary: bool = False
    selects_signals: bool = True

    @property
    def option(self) -> str:
        """The option of `scanrack export`, such as "--csv"."""
        return f"--{self.name}"
