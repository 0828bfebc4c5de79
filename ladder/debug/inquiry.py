"""Answers between scans: the last change of a tag, and the cause of its value."""

from __future__ import annotations

from collections.abc import Container

from ..model.operands import Group, Place
from ..model.resolver import Resolver
from ..model.tags import Leaf
from .cells import cells_of, is_counted
from .chart_waits import waits_of
from .crossref import CrossReference
from .replay import Replayer
from .watched import Change, shown
from .watching import WatchedEngine
from .why import changes_of, explain_cause, explain_change, explain_unchanged, most_relevant, state_of


class Inquiry:
    """Answers questions about a program from its engine, past scans, forces and cross reference."""

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
        """Return the last remembered change in a tag between scans; None if there is none."""
        operand = self._resolver.named(tag)
        scan = self._past.last_change_of(cells_of(operand), self._latest)
        if scan is None and is_counted(operand):  # ACC changes in most scans; the bits matter more
            scan = self._past.last_change_of(cells_of(operand, counts=True), self._latest)
        if scan is None:
            return None
        return most_relevant(changes_of(self._past.again(scan).history, operand), operand)

    def cause(self, tag: str) -> tuple[int, str] | None:
        """Return the scan of a tag's last change, and its cause; None if it has not changed."""
        change = self.last_change(tag)
        return None if change is None else (change.scan, explain_cause(self._engine.lowered, change))

    def why(self, tag: str) -> str:
        """Explain a tag's value: the scan and rung of its last change, and the rung's false conditions.

        For a step of a chart, the answer also has the conditions that begin or end it.
        """
        waits = waits_of(self._engine.lowered, self._engine.tags, self._resolver.named(tag))
        return "\n".join([self._why(tag), *waits])

    def _why(self, tag: str) -> str:
        """Explain a tag's value by its force, its last change, its module, or its possible writers."""
        value = self._engine.tags[tag]
        operand = self._resolver.named(tag)
        address = operand.address if isinstance(operand, Place) else None
        if self._resolver.base_name(tag) in self._forced or address in self._forced:
            return f"{tag} is {shown(value)} because it is forced."
        lowered, reported = self._engine.lowered, _input_of(operand)
        is_only_reported = reported is not None and reported.ident not in lowered.written_inputs
        change = None if is_only_reported else self.last_change(tag)
        if change is not None:
            return explain_change(lowered, tag, operand, change, value)
        if reported is not None:
            return f"{tag} is {shown(value)} because the module reports it: it is an input image."
        writers = [mention for mention in self._cross_reference.of(tag) if mention.writes]
        return explain_unchanged(tag, state_of(operand, value), writers)


def _input_of(operand: Place | Group) -> Leaf | None:
    """Return the input image or fault that contains a single value; None for any other operand."""
    return operand.leaf if isinstance(operand, Place) and operand.leaf.is_input else None
