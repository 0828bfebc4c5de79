"""Answers after a scan: the last change of a tag, and the cause of its value."""

from __future__ import annotations

from collections.abc import Container

from ..model.operands import Place
from ..model.resolver import Resolver
from .cells import cells_of, is_counted
from .chart_waits import waits_of
from .crossref import CrossReference
from .replay import Replayer
from .watched import Change, shown
from .watching import WatchedEngine
from .why import changes_of, explain_cause, explain_change, explain_unchanged, most_relevant, state_of


class Inquiry:
    """Answers questions about a program, from its engine, past scans, forces and cross reference."""

    def __init__(
        self,
        engine: WatchedEngine,
        past: Replayer,
        latest: int,
        forced: Container[str | None],
        cross_reference: CrossReference,
    ) -> None:
        self._engine, self._past, self._latest, self._forced = engine, past, latest, forced
        self._cross_reference = cross_reference
        self._resolver = Resolver(engine.lowered.layout)

    def last_change(self, tag: str) -> Change | None:
        """Return the last remembered change of a tag between scans, or None."""
        where = self._resolver.named(tag)
        scan = self._past.last_change_of(cells_of(where), self._latest)
        if scan is None and is_counted(where):  # ACC changes in most scans; the bits matter more
            scan = self._past.last_change_of(cells_of(where, counts=True), self._latest)
        if scan is None:
            return None
        return most_relevant(changes_of(self._past.again(scan).history, where), where)

    def cause(self, tag: str) -> tuple[int, str] | None:
        """Return the scan of the last change of a tag, and what made it; None if nothing is known."""
        change = self.last_change(tag)
        return None if change is None else (change.scan, explain_cause(self._engine.lowered, change))

    def why(self, tag: str) -> str:
        """Explain a tag's value: scan and rung of its last change, and the false conditions there.

        The answer about a step of a chart has also what would begin or end it.
        """
        waits = waits_of(self._engine.lowered, self._engine.tags, self._resolver.named(tag))
        return "\n".join([self._why(tag), *waits])

    def _why(self, tag: str) -> str:
        value = self._engine.tags[tag]
        where = self._resolver.named(tag)
        address = where.address if isinstance(where, Place) else None
        if self._resolver.base_name(tag) in self._forced or address in self._forced:
            return f"{tag} is {shown(value)} because it is forced."
        lowered = self._engine.lowered
        image = where.leaf if isinstance(where, Place) and where.leaf.slot is not None else None
        is_input = image is not None and not image.output
        is_written = not is_input or (image is not None and image.ident in lowered.written_inputs)
        change = self.last_change(tag) if is_written else None
        if is_input and change is None:
            return f"{tag} is {shown(value)} because the module reports it: it is an input image."
        if change is None:
            writers = [each for each in self._cross_reference.of(tag) if each.writes]
            return explain_unchanged(tag, state_of(where, value), writers)
        return explain_change(lowered, tag, where, change, value)
