"""Browsing the OPC UA server: Browse and BrowseNext, with continuation points [OPC UA part 4, 5.9].

asyncua (2.1) returns all references of a node, as they were added: it has neither continuation points nor
result masks, and takes any direction and type of references. References that lead back have no names there.
Here each row of the tables of result codes has its check:

    Browse, service        BadNothingToDo, BadTooManyOperations: `opcua_services.py`;
                           BadViewIdUnknown, since there is no view
    Browse, operation      BadNodeIdInvalid, BadNodeIdUnknown, BadBrowseDirectionInvalid,
                           BadReferenceTypeIdInvalid, BadNoContinuationPoints
    BrowseNext, operation  BadContinuationPointInvalid
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from itertools import count, islice
from typing import Any, NamedTuple

CONTINUATIONS_MOST = 16
"""Continuation points of a session; the oldest is released for a new request."""


class _Paused(NamedTuple):
    """A browse that goes on behind a continuation point."""

    edition: int
    rest: Iterator[Any]
    next: Any  # the first one of the rest
    most: int


class Views:
    """The references of all nodes.

    Args:
        space: asyncua's address space.
    """

    def __init__(self, space: Any) -> None:
        self._ua: Any = import_module("asyncua.ua")
        self.space = space
        self.edition = 0
        ids = self._ua.ObjectIds
        self._subtype, self._definition = map(self._ua.NodeId, (ids.HasSubtype, ids.HasTypeDefinition))

    def refusal(self, wanted: Any) -> str:
        """Return the name of the status that refuses a browse; "" for none."""
        if wanted.NodeId.is_null():
            return "BadNodeIdInvalid"
        if wanted.NodeId not in self.space:
            return "BadNodeIdUnknown"
        if wanted.BrowseDirection == self._ua.BrowseDirection.Invalid:
            return "BadBrowseDirectionInvalid"
        kind = wanted.ReferenceTypeId
        if not kind.is_null() and self._class_of(kind) != self._ua.NodeClass.ReferenceType:
            return "BadReferenceTypeIdInvalid"
        return ""

    def references(self, wanted: Any) -> Iterator[Any]:
        """Yield the references that a browse asks for."""
        ua = self._ua
        directions = {ua.BrowseDirection.Forward: (True,), ua.BrowseDirection.Inverse: (False,)}
        forward = directions.get(wanted.BrowseDirection, (True, False))
        kinds = None if wanted.ReferenceTypeId.is_null() else {wanted.ReferenceTypeId}
        if kinds is not None and wanted.IncludeSubtypes:
            kinds.update(self._subtypes(wanted.ReferenceTypeId))
        for each in self.space[wanted.NodeId].references:
            if each.IsForward not in forward or (kinds is not None and each.ReferenceTypeId not in kinds):
                continue
            if not wanted.NodeClassMask or wanted.NodeClassMask & self._class_of(each.NodeId, each.NodeClass):
                yield self._described(each, wanted.ResultMask)

    def _subtypes(self, kind: Any) -> Iterator[Any]:
        for each in self.space[kind].references:
            if each.ReferenceTypeId == self._subtype and each.IsForward:
                yield each.NodeId
                yield from self._subtypes(each.NodeId)

    def _class_of(self, node_id: Any, otherwise: Any = 0) -> Any:
        node = self.space.get(node_id)
        return otherwise if node is None else self._value(node, self._ua.AttributeIds.NodeClass)

    @staticmethod
    def _value(node: Any, attribute: Any) -> Any:
        return node.attributes[attribute].value.Value.Value

    def _described(self, reference: Any, mask: int) -> Any:
        """Return a reference with the fields of the mask; names are those of the target."""
        ua = self._ua
        masks, ids, target = ua.BrowseResultMask, ua.AttributeIds, self.space.get(reference.NodeId)
        made = ua.ReferenceDescription(NodeId=reference.NodeId)
        if mask & masks.ReferenceTypeId:
            made.ReferenceTypeId = reference.ReferenceTypeId
        if mask & masks.IsForward:
            made.IsForward = reference.IsForward
        if target is None:
            return made
        node_class = ua.NodeClass(self._value(target, ids.NodeClass))
        if mask & masks.NodeClass:
            made.NodeClass = node_class
        if mask & masks.BrowseName:
            made.BrowseName = self._value(target, ids.BrowseName)
        if mask & masks.DisplayName:
            made.DisplayName = self._value(target, ids.DisplayName)
        if mask & masks.TypeDefinition and node_class in (ua.NodeClass.Object, ua.NodeClass.Variable):
            kinds = (each for each in target.references if each.ReferenceTypeId == self._definition)
            made.TypeDefinition = next((each.NodeId for each in kinds if each.IsForward), ua.NodeId())
        return made


class Browsing:
    """The browses of a session."""

    def __init__(self, views: Views) -> None:
        self._ua: Any = import_module("asyncua.ua")
        self._error: Any = import_module("asyncua.common.utils").ServiceError
        self._views = views
        self._paused: dict[bytes, _Paused] = {}
        self._numbers = count(1)

    async def browse(self, params: Any) -> list[Any]:
        """Answer Browse."""
        if not params.View.ViewId.is_null():
            raise self._error(self._ua.StatusCodes.BadViewIdUnknown)
        most, before = params.RequestedMaxReferencesPerNode, list(self._paused)
        results = []
        for each in params.NodesToBrowse:
            if refusal := self._views.refusal(each):
                results.append(self._bad(refusal))
            else:
                results.append(self._results(self._views.references(each), most, before))
        return results

    async def browse_next(self, params: Any) -> list[Any]:
        """Answer BrowseNext; no results if points are released."""
        if params.ReleaseContinuationPoints:
            for point in params.ContinuationPoints:
                self._paused.pop(point, None)
            return []
        results = []
        for point in params.ContinuationPoints:
            paused = self._paused.pop(point, None)
            if paused is None or paused.edition != self._views.edition:
                results.append(self._bad("BadContinuationPointInvalid"))
            else:
                results.append(self._results(paused.rest, paused.most, [], paused.next))
        return results

    def _bad(self, code: str) -> Any:
        return self._ua.BrowseResult(self._ua.StatusCode(getattr(self._ua.StatusCodes, code)))

    def _results(self, rest: Iterator[Any], most: int, before: list[bytes], first: Any = None) -> Any:
        """Return the next references, and a point behind which there are more.

        Args:
            most: references; 0 = all.
            before: points of earlier requests, which may be released.
        """
        found = [] if first is None else [first]
        found += islice(rest, most - len(found)) if most else rest
        following = next(rest, None) if most else None
        if following is None:
            return self._ua.BrowseResult(References=found)
        while len(self._paused) >= CONTINUATIONS_MOST:
            if not before:
                return self._bad("BadNoContinuationPoints")
            self._paused.pop(before.pop(0), None)
        point = next(self._numbers).to_bytes(8, "big")
        self._paused[point] = _Paused(self._views.edition, rest, following, most)
        return self._ua.BrowseResult(ContinuationPoint=point, References=found)
