"""Events besides input changes; each event that a proof excludes is listed as an assumption."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Self

PROGRAM_MODE, RETAINED_START, LOST_LINK = "program mode", "retained start", "lost link"

LEFT_OUT = {
    PROGRAM_MODE: "the key stays in run: no change to program mode and back, which would prescan",
    RETAINED_START: "runs begin with power-up and initial values, not with retained tags",
    LOST_LINK: "no module is pulled or loses its link",
}
"""The assumption for each event that is excluded."""

KEPT = "retained tags are as the program has left them between two scans, without a major fault"
"""The assumption if runs may begin with retained tags."""


@dataclass(frozen=True, slots=True)
class Happenings:
    """The events that may happen between two scans of a proof.

    Attributes:
        program_mode: the key is turned to program and back to run.
        retained_start: a run ends, and the next run begins with its tags, as with `scanrack run --retain`.
        lost_link: a module is removed or loses its link, and comes back; for one or more scans it keeps no
            contract.
    """

    program_mode: bool = True
    retained_start: bool = False
    lost_link: bool = False

    @classmethod
    def of(cls, names: Iterable[str]) -> Self:
        """Return the events that a list names, such as `happens` in a rack file.

        >>> Happenings.of(["lost link"])
        Happenings(program_mode=False, retained_start=False, lost_link=True)
        """
        names = set(names)
        return cls(*[each in names for each in LEFT_OUT])

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the events that may happen."""
        given = self.program_mode, self.retained_start, self.lost_link
        return tuple(name for name, truth in zip(LEFT_OUT, given, strict=True) if truth)

    def assumed(self) -> Iterator[str]:
        """Yield a sentence for each event that a proof excludes, with the option that includes it."""
        if self.retained_start:
            yield KEPT
        for name, sentence in LEFT_OUT.items():
            if name not in self.names:
                more = ", ".join(f'"{each}"' for each in LEFT_OUT if each in (*self.names, name))
                yield f"{sentence} (happens = [{more}])"


RUN_ONLY = Happenings(program_mode=False)
"""Only scans happen."""
