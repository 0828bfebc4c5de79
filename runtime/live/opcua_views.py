"""Browsing the OPC UA server: Browse and BrowseNext, with continuation points [OPC UA part 4, 5.9].

asyncua (2.1) returns all references of a node with all fields. It has no continuation points, and accepts any
direction and reference type. This module checks each row of the tables of result codes:

    Browse, service        BadNothingToDo, BadTooManyOperations: `opcua_services.py`;
                           BadViewIdUnknown, since the server has no views
    Browse, operation      BadNodeIdInvalid, BadNodeIdUnknown, BadBrowseDirectionInvalid,
                           BadReferenceTypeIdInvalid, BadNoContinuationPoints
    BrowseNext, operation  BadContinuationPointInvalid
    TranslateBrowsePaths   BadNodeIdInvalid, BadNodeIdUnknown, BadNothingToDo, BadBrowseNameInvalid
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterator
from itertools import count, islice
from typing import Any, NamedTuple

from .opcua_library import service_error, status, ua

FIELDS = ("ReferenceTypeId", "IsForward", "NodeClass", "BrowseName", "DisplayName", "TypeDefinition")
"""Fields of a reference that a result mask names."""

CONTINUATIONS_MOST = 16
"""Maximum number of continuation points per session; a new request releases the oldest ones."""


class _Continuation(NamedTuple):
    """A browse that can be continued at a continuation point."""

    edition: int  # the edition of the views in which the browse began
    references: Iterator[Any]  # the remaining references after `first`
    first: Any  # the next reference
    most: int  # maximum number of references per request


class Views:
    """The references of all nodes.

    Args:
        space: asyncua's address space.
    """

    def __init__(self, space: Any) -> None:
        self.space = space
        self.edition = 0
        self._subtype = ua.NodeId(ua.ObjectIds.HasSubtype)
        self._fields = [field for field in ua.BrowseResultMask if field.name in FIELDS]
        self._all = sum(self._fields)

    def _start_refusal(self, node_id: Any) -> str:
        """Return the name of the status that refuses a node, or "" if the node exists."""
        if node_id.is_null():
            return "BadNodeIdInvalid"
        return "" if node_id in self.space else "BadNodeIdUnknown"

    def path_refusal(self, path: Any) -> str:
        """Return the name of the status that refuses a path, or "" if the path is allowed."""
        if refusal := self._start_refusal(path.StartingNode):
            return refusal
        elements = path.RelativePath.Elements
        if not elements:
            return "BadNothingToDo"
        return "" if all(element.TargetName.Name for element in elements) else "BadBrowseNameInvalid"

    def refusal(self, description: Any) -> str:
        """Return the name of the status that refuses a browse, or "" if the browse is allowed."""
        if refusal := self._start_refusal(description.NodeId):
            return refusal
        if description.BrowseDirection == ua.BrowseDirection.Invalid:
            return "BadBrowseDirectionInvalid"
        kind = description.ReferenceTypeId
        if not kind.is_null() and not self._is_reference_type(kind):
            return "BadReferenceTypeIdInvalid"
        return ""

    def references(self, description: Any) -> Iterator[Any]:
        """Yield the references of a node that a browse requests, with only the requested fields."""
        directions = {ua.BrowseDirection.Forward: (True,), ua.BrowseDirection.Inverse: (False,)}
        forward = directions.get(description.BrowseDirection, (True, False))
        kinds = None if description.ReferenceTypeId.is_null() else {description.ReferenceTypeId}
        if kinds is not None and description.IncludeSubtypes:
            kinds.update(self._subtypes(description.ReferenceTypeId))
        for reference in self.space[description.NodeId].references:
            if reference.IsForward not in forward:
                continue
            if kinds is not None and reference.ReferenceTypeId not in kinds:
                continue
            if not description.NodeClassMask or description.NodeClassMask & reference.NodeClass:
                yield self._masked(reference, description.ResultMask)

    def _subtypes(self, kind: Any) -> Iterator[Any]:
        """Yield the types below a reference type, at any depth."""
        for reference in self.space[kind].references:
            if reference.ReferenceTypeId == self._subtype and reference.IsForward:
                yield reference.NodeId
                yield from self._subtypes(reference.NodeId)

    def _is_reference_type(self, node_id: Any) -> bool:
        node, key = self.space.get(node_id), ua.AttributeIds.NodeClass
        return node is not None and bool(node.attributes[key].value.Value.Value == ua.NodeClass.ReferenceType)

    def _masked(self, reference: Any, mask: int) -> Any:
        """Return a reference with only the fields that a mask selects."""
        if mask & self._all == self._all:
            return reference
        masked = ua.ReferenceDescription(NodeId=reference.NodeId)
        for field in self._fields:
            if mask & field:
                setattr(masked, field.name, getattr(reference, field.name))
        return masked


class Browsing:
    """Carries out a session's browses.

    Args:
        translate: asyncua's service.
    """

    def __init__(self, views: Views, translate: Callable[[list[Any]], Awaitable[list[Any]]]) -> None:
        self._translate = translate
        self._views = views
        self._paused: dict[bytes, _Continuation] = {}
        self._numbers = count(1)

    async def browse(self, params: Any) -> list[Any]:
        """Answer Browse; return a result for each node: its references, or the status that refuses it."""
        if not params.View.ViewId.is_null():
            raise service_error("BadViewIdUnknown")
        references_most, paused_before = params.RequestedMaxReferencesPerNode, list(self._paused)
        browse_results = []
        for description in params.NodesToBrowse:
            if refusal := self._views.refusal(description):
                browse_results.append(ua.BrowseResult(status(refusal)))
            else:
                browse_results.append(
                    self._results(self._views.references(description), references_most, paused_before)
                )
        return browse_results

    async def translate(self, paths: list[Any]) -> list[Any]:
        """Answer TranslateBrowsePathsToNodeIds; asyncua resolves valid paths."""
        path_results = []
        for path in paths:
            if refusal := self._views.path_refusal(path):
                path_results.append(ua.BrowsePathResult(status(refusal)))
            else:
                path_results += await self._translate([path])
        return path_results

    async def browse_next(self, params: Any) -> list[Any]:
        """Answer BrowseNext; return no results if the request releases continuation points."""
        if params.ReleaseContinuationPoints:
            for point in params.ContinuationPoints:
                self._paused.pop(point, None)
            return []
        results = []
        for point in params.ContinuationPoints:
            paused = self._paused.pop(point, None)
            if paused is None or paused.edition != self._views.edition:
                results.append(ua.BrowseResult(status("BadContinuationPointInvalid")))
            else:
                results.append(self._results(paused.references, paused.most, [], paused.first))
        return results

    def _results(
        self, references: Iterator[Any], most: int, releasable: list[bytes], first: Any = None
    ) -> Any:
        """Return the next references, and a continuation point if there are more.

        Args:
            references: the remaining references, after `first` if it is not None.
            most: maximum number of references; 0 for no limit.
            releasable: continuation points of earlier requests, oldest first.
        """
        page = [] if first is None else [first]
        page += islice(references, most - len(page)) if most else references
        next_reference = next(references, None) if most else None
        if next_reference is None:
            return ua.BrowseResult(References=page)
        while len(self._paused) >= CONTINUATIONS_MOST:
            if not releasable:
                return ua.BrowseResult(status("BadNoContinuationPoints"))
            self._paused.pop(releasable.pop(0), None)
        point = next(self._numbers).to_bytes(8, "big")
        self._paused[point] = _Continuation(self._views.edition, references, next_reference, most)
        return ua.BrowseResult(ContinuationPoint=point, References=page)
