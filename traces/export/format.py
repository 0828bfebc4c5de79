"""A format of export: each module of a format defines one as `FORMAT`, and `formats` lists them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from ..files.guard import FileKind


@dataclass(frozen=True, slots=True, kw_only=True)
class ExportFormat:
    """A format of export; `scanrack export` and its pages follow from it.

    Attributes:
        name: of its option, letters: "csv" is `--csv OUT`.
        kind: the kind of its files; a file of another kind is not replaced.
        write: writes a trace, see `write_csv`; takes no `signals` unless `chooses`.
        help: help text of the option.
        holds: contents of the file, for docs/query.md.
        reader: programs that read it, for docs/query.md.
        binary: whether it consists of bytes, on standard output, too.
        chooses: whether signals can be chosen.
    """

    name: str
    kind: FileKind
    write: Callable[..., int]
    help: str
    holds: str
    reader: str
    binary: bool = False
    chooses: bool = True

    @property
    def option(self) -> str:
        """Its option."""
        return f"--{self.name}"
