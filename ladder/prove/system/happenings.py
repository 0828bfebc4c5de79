"""What may happen to a rack beside its inputs; what a proof leaves out is an assumption, with its option."""

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
"""What is assumed if something does not happen."""

KEPT = "retained tags are as the program has left them between two scans, without a major fault"
"""What is assumed if runs begin with retained tags, too."""


@dataclass(frozen=True, slots=True)
class Happenings:
    """What may happen between two scans of a proof.

    Attributes:
        program_mode: the key is turned to program and back to run.
        retained_start: a run ends, and the next one begins with its tags, as `scanrack run --retain` does.
        lost_link: a module is pulled, or loses its link, and comes back: for a scan or more it keeps no
            contract.
    """

    program_mode: bool = True
    retained_start: bool = False
    lost_link: bool = False

    @classmethod
    def of(cls, names: Iterable[str]) -> Self:
        """Return what a list names, as `happens` in a rack file.

        >>> Happenings.of(["lost link"])
        Happenings(program_mode=False, retained_start=False, lost_link=True)
        """
        names = set(names)
        return cls(*[each in names for each in LEFT_OUT])

    @property
    def names(self) -> tuple[str, ...]:
        """What may happen, as a list."""
        given = self.program_mode, self.retained_start, self.lost_link
        return tuple(name for name, truth in zip(LEFT_OUT, given, strict=True) if truth)

    def assumed(self) -> Iterator[str]:
        """Yield what a proof leaves out, a sentence each, with the option that takes it in."""
        if self.retained_start:
            yield KEPT
        for name, sentence in LEFT_OUT.items():
            if name not in self.names:
                more = ", ".join(f'"{each}"' for each in LEFT_OUT if each in (*self.names, name))
                yield f"{sentence} (happens = [{more}])"


RUN_ONLY = Happenings(program_mode=False)
"""Nothing but scans."""
