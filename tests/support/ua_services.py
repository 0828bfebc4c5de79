"""Services of OPC UA as plain steps, sent with asyncua; tests/peers/services_ua.cjs does it with node-opcua.

A case is a list of steps, and so is what comes back: the status of a service that is refused, or its results.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any

Step = dict[str, Any]

VALUE, SOURCE, SERVER, BOTH, NEITHER = 13, 0, 1, 2, 3
FORWARD, INVERSE, BOTH_WAYS = 0, 1, 2
ALL_FIELDS = 63


def node(name: str, attribute: int = VALUE, part: str = "", encoding: str = "") -> Step:
    """Return what names an attribute."""
    return {"node": name, "attribute": attribute, "range": part, "encoding": encoding}


def read(*nodes: Step, age: float = 0, timestamps: int = NEITHER) -> Step:
    """Return a Read request."""
    return {"service": "read", "nodes": list(nodes), "age": age, "timestamps": timestamps}


def value(kind: str, of: Any, dims: Sequence[int] | None = None) -> Step:
    """Return a value: a list is an array, one with dimensions is given flat."""
    return {"type": kind, "value": of, "dims": dims and list(dims)}


def to(
    name: str,
    of: Step | None,
    *,
    attribute: int = VALUE,
    part: str = "",
    status: str = "",
    source: bool = False,
    server: bool = False,
) -> Step:
    """Return what is written to a node."""
    return node(name, attribute, part) | {"value": of, "status": status, "source": source, "server": server}


def write(*nodes: Step) -> Step:
    """Return a Write request."""
    return {"service": "write", "nodes": list(nodes)}


def start(
    name: str,
    direction: int = FORWARD,
    *,
    type: str = "i=0",
    subtypes: bool = True,
    classes: int = 0,
    fields: int = ALL_FIELDS,
) -> Step:
    """Return where a browse starts."""
    found: Step = {"node": name, "direction": direction, "type": type, "subtypes": subtypes}
    return found | {"classes": classes, "fields": fields}


def browse(*nodes: Step, most: int = 0, view: str = "") -> Step:
    """Return a Browse request."""
    return {"service": "browse", "nodes": list(nodes), "most": most, "view": view}


def translate(*paths: tuple[str, Sequence[str]], inverse: bool = False) -> Step:
    """Return a TranslateBrowsePathsToNodeIds request: where paths start, and the names on them."""
    made = [{"node": name, "names": list(names)} for name, names in paths]
    return {"service": "translate", "paths": made, "inverse": inverse}


def browse_next(*points: str, release: bool = False) -> Step:
    """Return a BrowseNext request; a point is `STEP.RESULT`, another text one that does not exist."""
    return {"service": "next", "points": list(points), "release": release}


def items(
    *nodes: Step, timestamps: int = NEITHER, other: bool = False, deadband: tuple[int, float] | None = None
) -> Step:
    """Return a CreateMonitoredItems request to the subscription of the case, or to no subscription.

    Args:
        deadband: its type (1 absolute, 2 percent) and value.
    """
    found: Step = {"service": "items", "nodes": list(nodes), "timestamps": timestamps, "other": other}
    return found | {"deadband": deadband}


def modify(*items: int, timestamps: int = NEITHER, other: bool = False) -> Step:
    """Return a ModifyMonitoredItems request; items are numbers of those that were made, -1 is none."""
    return {"service": "modify", "items": list(items), "timestamps": timestamps, "other": other}


def publish(*acknowledge: int, other: bool = False) -> Step:
    """Return a Publish request."""
    return {"service": "publish", "acknowledge": list(acknowledge), "other": other}


def republish(number: int, *, other: bool = False) -> Step:
    """Return a Republish request."""
    return {"service": "republish", "number": number, "other": other}


def subscribe(lifetime: int = 1_000, alive: int = 10) -> Step:
    """Return a CreateSubscription request, in publishing intervals."""
    return {"service": "subscribe", "lifetime": lifetime, "alive": alive}


class Services:
    """A case, step by step, with asyncua."""

    def __init__(self, client: Any) -> None:
        from asyncua import ua

        self._client, self._ua = client, ua
        self._points: dict[str, Any] = {}

    async def run(self, steps: Sequence[Step]) -> list[Any]:
        """Return what each step brings."""
        from asyncua.ua.uaerrors import UaStatusCodeError

        found: list[Any] = []
        for step in steps:
            request, results = getattr(self, f"_{step['service']}")(step)
            try:
                data = await self._client.uaclient.protocol.send_request(request)
            except UaStatusCodeError as error:
                found.append(type(error).__name__)
                continue
            name = type(request).__name__.replace("Request", "Response")
            response = self._ua.ua_binary.struct_from_binary(getattr(self._ua, name), data)
            made = getattr(response, "Results", None) or getattr(
                getattr(response, "Parameters", None), "Results", []
            )
            for at, each in enumerate(made):
                if getattr(each, "ContinuationPoint", None):
                    self._points[f"{len(found)}.{at}"] = each.ContinuationPoint
            found.append(results(response, made))
        return found

    def _id(self, name: str) -> Any:
        return self._ua.NodeId.from_string(name if name.startswith(("ns=", "i=")) else f"ns=2;s={name}")

    def _named(self, each: Step) -> Any:
        encoding = self._ua.QualifiedName(each["encoding"] or None)
        return self._ua.ReadValueId(
            self._id(each["node"]), each["attribute"], each["range"] or None, encoding
        )

    def _shown(self, found: Any) -> Step:
        variant = found.Value
        has_value = variant is not None and variant.VariantType.value
        dims = list(variant.Dimensions) if has_value and variant.Dimensions else None
        flat: Any = variant.Value if has_value else None
        for _ in (dims or ())[1:]:
            flat = list(itertools.chain.from_iterable(flat))
        return {
            "status": found.StatusCode.name,
            "value": flat,
            "dims": dims,
            "source": found.SourceTimestamp is not None,
            "server": found.ServerTimestamp is not None,
        }

    def _read(self, step: Step) -> Any:
        request = self._ua.ReadRequest()
        request.Parameters.MaxAge, request.Parameters.TimestampsToReturn = step["age"], step["timestamps"]
        request.Parameters.NodesToRead = list(map(self._named, step["nodes"]))
        return request, lambda _, results: list(map(self._shown, results))

    def _variant(self, given: Step | None) -> Any:
        ua = self._ua
        if given is None:
            return ua.Variant(None)
        of, kind = given["value"], ua.VariantType[given["type"]]
        of = bytes(of) if given["type"] == "ByteString" else of
        return ua.Variant(of, kind, given["dims"], isinstance(of, list))

    def _written(self, each: Step) -> Any:
        ua, then = self._ua, datetime(2020, 1, 1, tzinfo=UTC)
        status = ua.StatusCode(getattr(ua.StatusCodes, each["status"])) if each["status"] else None
        times = [then if each[name] else None for name in ("source", "server")]
        data = ua.DataValue(self._variant(each["value"]), status, *times)
        return ua.WriteValue(self._id(each["node"]), each["attribute"], each["range"] or None, data)

    def _write(self, step: Step) -> Any:
        request = self._ua.WriteRequest()
        request.Parameters.NodesToWrite = list(map(self._written, step["nodes"]))
        return request, lambda _, results: [each.name for each in results]

    def _start(self, each: Step) -> Any:
        numbers = (each["subtypes"], each["classes"], each["fields"])
        return self._ua.BrowseDescription(
            self._id(each["node"]), each["direction"], self._id(each["type"]), *numbers
        )

    @staticmethod
    def _browsed(found: Any) -> Step:
        return {
            "status": found.StatusCode.name,
            "names": [each.BrowseName.Name for each in found.References],
            "types": [each.TypeDefinition.Identifier for each in found.References],
            "more": bool(found.ContinuationPoint),
        }

    def _browse(self, step: Step) -> Any:
        request = self._ua.BrowseRequest()
        if step["view"]:
            request.Parameters.View.ViewId = self._id(step["view"])
        request.Parameters.RequestedMaxReferencesPerNode = step["most"]
        request.Parameters.NodesToBrowse = list(map(self._start, step["nodes"]))
        return request, lambda _, results: list(map(self._browsed, results))

    def _next(self, step: Step) -> Any:
        request = self._ua.BrowseNextRequest()
        request.Parameters.ReleaseContinuationPoints = step["release"]
        request.Parameters.ContinuationPoints = [self._points.get(each, b"none") for each in step["points"]]
        return request, lambda _, results: list(map(self._browsed, results))

    def _translate(self, step: Step) -> Any:
        ua, request = self._ua, self._ua.TranslateBrowsePathsToNodeIdsRequest()
        kind = ua.NodeId(ua.ObjectIds.HierarchicalReferences)
        request.Parameters.BrowsePaths = [
            ua.BrowsePath(
                self._id(each["node"]),
                ua.RelativePath(
                    [
                        ua.RelativePathElement(kind, step["inverse"], True, ua.QualifiedName(name or None, 2))
                        for name in each["names"]
                    ]
                ),
            )
            for each in step["paths"]
        ]
        return request, lambda _, results: [
            [each.StatusCode.name, *(target.TargetId.Identifier for target in each.Targets)]
            for each in results
        ]

    def _subscribe(self, step: Step) -> Any:
        request = self._ua.CreateSubscriptionRequest()
        parameters = request.Parameters
        parameters.RequestedPublishingInterval, parameters.PublishingEnabled = 50.0, True
        parameters.RequestedLifetimeCount = step["lifetime"]
        parameters.RequestedMaxKeepAliveCount = step["alive"]

        def made(response: Any, _results: Any) -> list[int]:
            made = response.Parameters
            self._points["subscription"] = made.SubscriptionId
            return [made.RevisedLifetimeCount, made.RevisedMaxKeepAliveCount]

        return request, made

    def _number(self, step: Step) -> int:
        return 4711 if step["other"] else int(self._points["subscription"])

    def _items(self, step: Step) -> Any:
        ua, request = self._ua, self._ua.CreateMonitoredItemsRequest()
        asked = ua.MonitoringParameters(ClientHandle=7, QueueSize=1)
        if step["deadband"]:
            trigger = ua.DataChangeTrigger.StatusValue
            asked.Filter = ua.DataChangeFilter(trigger, *step["deadband"])
        made = [
            ua.MonitoredItemCreateRequest(self._named(each), ua.MonitoringMode.Reporting, asked)
            for each in step["nodes"]
        ]
        request.Parameters = ua.CreateMonitoredItemsParameters(self._number(step), step["timestamps"], made)

        def found(_response: Any, results: Any) -> list[str]:
            self._points["items"] = [each.MonitoredItemId for each in results]
            return [each.StatusCode.name for each in results]

        return request, found

    def _modify(self, step: Step) -> Any:
        ua, request = self._ua, self._ua.ModifyMonitoredItemsRequest()
        asked = ua.MonitoringParameters(ClientHandle=7, QueueSize=1)
        known = self._points.get("items", [])
        numbers = [known[each] if each >= 0 else 4711 for each in step["items"]]
        changed = [ua.MonitoredItemModifyRequest(each, asked) for each in numbers]
        request.Parameters = ua.ModifyMonitoredItemsParameters(
            self._number(step), step["timestamps"], changed
        )
        return request, lambda _, results: [each.StatusCode.name for each in results]

    def _changed(self, message: Any) -> list[Step]:
        data = message.NotificationData or ()
        return [self._shown(item.Value) for each in data for item in each.MonitoredItems]

    def _publish(self, step: Step) -> Any:
        request = self._ua.PublishRequest()
        acknowledged = [
            self._ua.SubscriptionAcknowledgement(self._number(step), each) for each in step["acknowledge"]
        ]
        request.Parameters.SubscriptionAcknowledgements = acknowledged
        return request, lambda response, results: [
            [each.name for each in results],
            *self._changed(response.Parameters.NotificationMessage),
        ]

    def _republish(self, step: Step) -> Any:
        request = self._ua.RepublishRequest()
        request.Parameters.SubscriptionId = self._number(step)
        request.Parameters.RetransmitSequenceNumber = step["number"]
        return request, lambda response, _: self._changed(response.NotificationMessage)
