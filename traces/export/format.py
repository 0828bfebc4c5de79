"""A format of export: what its file has in `FORMAT`, and `formats` in its list."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from ..files.guard import FileKind


@dataclass(frozen=True, slots=True, kw_only=True)
class ExportFormat:
    """A format of export; `scanrack export` and its pages follow from it.

    Attributes:
        name: of its option, letters: "csv" is `--csv OUT`.
        kind: of its files; others are not replaced.
        write: writes a trace, see `write_csv`; without `signals` if it does not choose.
        help: of the option.
        holds: what the file has, for docs/query.md.
        reader: who reads it, for docs/query.md.
        binary: whether it is bytes, also on standard output.
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
