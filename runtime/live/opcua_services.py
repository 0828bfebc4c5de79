"""Checks and services that asyncua (2.1) lacks: list lengths, BrowseNext, unknown enumeration values.

BadNothingToDo          a request with an empty list
BadTooManyOperations    a request with more operations than the server's OperationLimits allow
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from .opcua_library import binary, service_error, ua

OPERATIONS_MOST = 10_000
"""Maximum number of operations in a request, as in the nodes of asyncua's OperationLimits."""

LISTS: Mapping[str, str] = {
    "read": "NodesToRead",
    "write": "NodesToWrite",
    "browse": "NodesToBrowse",
    "browse_next": "ContinuationPoints",
    "translate_browsepaths_to_nodeids": "",
    "call": "",
    "create_monitored_items": "ItemsToCreate",
    "modify_monitored_items": "ItemsToModify",
    "delete_monitored_items": "MonitoredItemIds",
    "set_monitoring_mode": "MonitoredItemIds",
    "set_publishing_mode": "SubscriptionIds",
    "delete_subscriptions": "",
}
"""The services of a session, and the field that lists their operations; "" if the argument is the list."""

Service = Callable[..., Awaitable[Any]]


def limit_operations(session: Any) -> None:
    """Refuse a session's requests if they contain too many operations, or no operations."""

    def limited(service: Service, name: str) -> Service:
        """Wrap a service that has its operations in the field `name`, see `LISTS`."""

        async def limiting(params: Any, *more: Any) -> Any:
            count = len((getattr(params, name) if name else params) or ())
            if not count and session.state.name != "Closed":  # the end of a session deletes any subscriptions
                raise service_error("BadNothingToDo")
            if count > OPERATIONS_MOST:
                raise service_error("BadTooManyOperations")
            return await service(params, *more)

        return limiting

    for name, operations in LISTS.items():
        setattr(session, name, limited(getattr(session, name), operations))


def accept_unknown_values() -> None:
    """Let asyncua read unknown values of enumerations as *Invalid*, which services refuse with a status."""
    for enumeration in (ua.TimestampsToReturn, ua.BrowseDirection):
        enumeration._missing_ = classmethod(lambda kind, _value: kind.Invalid)


def answer_browse_next(processor: Any) -> None:
    """Answer BrowseNext on a connection; asyncua does not support it."""
    process = processor._process_message
    browse_next = ua.NodeId(ua.ObjectIds.BrowseNextRequest_Encoding_DefaultBinary)

    async def processed(kind: Any, header: Any, sequence: Any, body: Any) -> Any:
        session = processor.session
        if kind != browse_next or session is None or not session.is_activated():
            return await process(kind, header, sequence, body)
        session.touch()
        params = binary.struct_from_binary(ua.BrowseNextParameters, body)
        response = ua.BrowseNextResponse()
        response.Parameters.Results = await session.browse_next(params)
        processor.send_response(header.RequestHandle, sequence, response)
        return True

    processor._process_message = processed
