"""Tags for a recorder whose values follow from the number of the scan."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from scanrack.traces import Tag
from scanrack.traces.format.tagplan import TagPlan, plan_of

Texts = Callable[[int], Mapping[str, Sequence[tuple[int, str]]]]
"""Returns the new codes and texts of a scan, by the name of the tag."""


def no_texts(_scan: int) -> Mapping[str, Sequence[tuple[int, str]]]:
    return {}


class MadeTags:
    """A source of tags; see `scanrack.traces.format.tagplan.TagSource`.

    Args:
        memory: the rack's memory block.
        tags: what is recorded.
        row: returns the row of a scan, its fields in the order of the plan.
        texts: returns the texts that begin in a scan.
    """

    def __init__(
        self,
        memory: bytes | bytearray,
        tags: Sequence[Tag],
        row: Callable[[int], bytes],
        texts: Texts = no_texts,
    ) -> None:
        self.plan: TagPlan = plan_of(tags)
        self.pending: list[tuple[str, Mapping[str, str | int]]] = []
        self._memory, self._row, self._texts, self._scan = memory, row, texts, -1

    def take(self) -> bytes:
        """Return memory block and row of the next scan."""
        self._scan += 1
        for tag, found in self._texts(self._scan).items():
            self.pending += [("/texts", {"tag": tag, "code": code, "text": text}) for code, text in found]
        return bytes(self._memory) + self._row(self._scan)
