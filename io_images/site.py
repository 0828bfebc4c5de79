"""A place in a user's program or file, for errors, faults and refusals; its texts are only for people."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Self

from .records import record


@record
class Site:
    """A place in a program or a file; unknown parts are "" or None."""

    program: str = ""
    routine: str = ""  # full name of the routine: `Main`, in a controller `\Program.Main`
    rung: int | None = None  # number of a rung, from 0; of a line, from 1; or of an element of a chart
    instruction: str = ""  # the instruction as text; in structured text, the statement
    unit: str = "rung"  # the unit that `rung` counts: "rung", "line", or "element" of a chart
    file: str = ""
    line: int | None = None  # line in the file, from 1
    column: int | None = None  # column in that line, from 1
    task: str = ""
    tag: str = ""
    key: str = ""  # key in a table of a file

    @property
    def place(self) -> str:
        """The place in the routine: `rung 3`, `line 12`."""
        return f"{self.unit} {self.rung}"

    @property
    def call(self) -> str:
        """The site without its program."""
        routine = self.routine.removeprefix(f"\\{self.program}.")
        return f"routine {routine}, {self.place}, {self.instruction}"

    @property
    def where(self) -> str:
        """The known parts: file, line, routine and rung."""
        rung = "" if self.rung is None else f", {self.place}"
        routine = f"routine {self.routine}{rung}" if self.routine else ""
        return ": ".join(filter(None, (self.spot if self.file else "", routine)))

    @property
    def spot(self) -> str:
        """File and line, such as `line.rung:12`; `line 12` if the file is unknown."""
        if self.file:
            return f"{self.file}:{self.line}" if self.line else self.file
        return f"line {self.line}"

    def __str__(self) -> str:
        return f"program {self.program}, {self.call}"


NOWHERE = Site()


class SiteError(ValueError):
    """An error in a user's text.

    Attributes:
        reason: the text of the error without the place.
        sites: the places of the mistakes.
    """

    def __init__(self, text: str, *sites: Site) -> None:
        super().__init__(text)
        self.reason, self.sites = text, sites

    @classmethod
    def at(cls, site: Site, reason: str) -> Self:
        """Return an error at a site; its text begins with the file and line."""
        error = cls(f"{site.spot}: {reason}", site)
        error.reason = reason
        return error

    @property
    def site(self) -> Site:
        """The place of the first mistake."""
        return self.sites[0] if self.sites else NOWHERE


class SettingError(SiteError):
    """The value of a parameter or a table's key is not allowed."""

    def __init__(self, key: str, text: str) -> None:
        super().__init__(text, Site(key=key))


def sites_of(error: BaseException | None) -> Iterator[Site]:
    """Yield the sites of an error, then the sites of its causes."""
    while error is not None:
        sites = getattr(error, "sites", None) or [getattr(error, "site", None)]
        yield from filter(None, sites)
        error = error.__cause__
