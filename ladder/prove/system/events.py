"""Events besides input changes; each event that a proof excludes is listed as an assumption."""

from __future__ import annotations

from collections.abc import Collection, Iterator

PROGRAM_MODE, RETAINED_START, LOST_LINK = "program mode", "retained start", "lost link"
"""The possible events between two scans, by their names in `happens` of a rack file.

PROGRAM_MODE    the key is turned to program and back to run
RETAINED_START  a run ends, and the next run begins with its tags, as with `scanrack run --retain`
LOST_LINK       a module is removed or loses its link, and comes back; its contracts do not apply for one or
                more scans
"""

LEFT_OUT = {
    PROGRAM_MODE: "the key stays in run: no change to program mode and back, which would prescan",
    RETAINED_START: "runs begin with power-up and initial values, not with retained tags",
    LOST_LINK: "no module is pulled or loses its link",
}
"""The assumption for each event that is excluded."""

KEPT = "retained tags are as the program has left them between two scans, without a major fault"
"""The assumption if runs may begin with retained tags."""

RUN_ONLY: tuple[str, ...] = ()
"""`happens` without any events, only scans."""


def assumed(happens: Collection[str]) -> Iterator[str]:
    """Yield a sentence for each event that a proof excludes, with the option that includes it.

    Args:
        happens: names of the possible events.
    """
    if RETAINED_START in happens:
        yield KEPT
    for name, sentence in LEFT_OUT.items():
        if name not in happens:
            listed = ", ".join(f'"{event}"' for event in LEFT_OUT if event in (*happens, name))
            yield f"{sentence} (happens = [{listed}])"
