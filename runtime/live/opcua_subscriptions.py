"""The parts of OPC UA subscriptions in which asyncua (2.1) deviates from OPC UA part 4, 5.13 and 5.14.

Publish      an unknown acknowledgment gets BadSequenceNumberUnknown; a session without a subscription gets
             BadNoSubscription
Republish    BadMessageNotAvailable and BadSubscriptionIdInvalid: a client repeats Republish until it gets one
             of them. A message is kept until it is acknowledged. Each Republish keeps the subscription alive
items        BadTimestampsToReturnInvalid, BadMonitoredItemIdInvalid, BadIndexRangeInvalid,
             BadDataEncodingInvalid, BadDataEncodingUnsupported, BadFilterNotAllowed,
             BadMonitoredItemFilterUnsupported, BadEventFilterInvalid; an item reports the index range and the
             timestamps of its request
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any

from ..tag_servers.index_ranges import parse_ranges
from .opcua_attributes import Attributes, BadStatusError
from .opcua_library import service_error, status, ua

KEEP_ALIVES = 3
"""Minimum lifetime of a subscription, as a number of intervals between its keep-alive messages."""


class Subscriptions:
    """The subscriptions of a session.

    Args:
        session: asyncua's session; its services are replaced.
        service: asyncua's service, with the subscriptions of all sessions.
    """

    def __init__(self, session: Any, service: Any, attributes: Attributes) -> None:
        self._session, self._service, self._attributes = session, service, attributes
        self._create_items, self._modify_items = (
            session.create_monitored_items,
            session.modify_monitored_items,
        )
        session.publish, session.republish = self.publish, self.republish
        session.create_monitored_items, session.modify_monitored_items = self.create_items, self.modify_items

    def _own_subscription(self, number: int) -> Any:
        """Return the session's subscription with this identifier, or None if there is none."""
        subscription = self._service.subscriptions.get(number)
        if subscription is None or subscription.session_id != self._session.session_id:
            return None
        return subscription

    def _subscription(self, params: Any) -> Any:
        """Return the subscription that a request names; refuse the request if the session lacks it."""
        subscription = self._own_subscription(params.SubscriptionId)
        if subscription is None:
            raise service_error("BadSubscriptionIdInvalid")
        return subscription

    def publish(self, acknowledged: Any = None) -> tuple[int, list[Any]]:
        """Acknowledge messages; return the number of subscriptions, and a status for each acknowledgment."""
        session = self._session.session_id
        own_count = sum(internal.session_id == session for internal in self._service.subscriptions.values())
        if not own_count:
            raise service_error("BadNoSubscription")
        results = []
        for receipt in acknowledged or ():
            subscription, code = self._own_subscription(receipt.SubscriptionId), "Good"
            if subscription is None:
                code = "BadSubscriptionIdInvalid"
            elif subscription._not_acknowledged_results.pop(receipt.SequenceNumber, None) is None:
                code = "BadSequenceNumberUnknown"
            results.append(status(code))
        return own_count, results

    def republish(self, params: Any) -> Any:
        """Return a message that the client has not acknowledged."""
        subscription = self._subscription(params)
        subscription._publish_cycles_count = 0
        notification = subscription._not_acknowledged_results.get(params.RetransmitSequenceNumber)
        if notification is None:
            raise service_error("BadMessageNotAvailable")
        return notification.NotificationMessage

    # --- monitored items

    async def create_items(self, params: Any) -> list[Any]:
        """Create the items that pass our checks; return a result for each item."""
        self._attributes.check_timestamps(params.TimestampsToReturn)
        service = self._subscription(params).monitored_item_srv
        refusals = list(map(self._refusal, params.ItemsToCreate))
        accepted = [item for item, refusal in zip(params.ItemsToCreate, refusals, strict=True) if not refusal]
        params.ItemsToCreate = accepted
        _shape(service, self._attributes).timestamps = params.TimestampsToReturn
        created = await self._create_items(params) if accepted else []
        for result in created:
            if result.StatusCode.is_good():
                service._monitored_items[result.MonitoredItemId].timestamps = params.TimestampsToReturn
        created_results = iter(created)  # of the accepted items, in order
        return [
            ua.MonitoredItemCreateResult(status(refusal)) if refusal else next(created_results)
            for refusal in refusals
        ]

    async def modify_items(self, params: Any) -> list[Any]:
        """Change the known items; return a result for each item."""
        self._attributes.check_timestamps(params.TimestampsToReturn)
        items = self._subscription(params).monitored_item_srv._monitored_items
        named_items = [items.get(request.MonitoredItemId) for request in params.ItemsToModify]
        params.ItemsToModify = [
            request
            for request, item in zip(params.ItemsToModify, named_items, strict=True)
            if item is not None
        ]
        changed = iter(await self._modify_items(params) if params.ItemsToModify else ())
        for item in named_items:
            if item is not None:
                item.timestamps = params.TimestampsToReturn
        unknown_status = status("BadMonitoredItemIdInvalid")
        return [
            next(changed) if item is not None else ua.MonitoredItemModifyResult(unknown_status)
            for item in named_items
        ]

    def _refusal(self, item: Any) -> str:
        """Return the name of the status that refuses an item, or "" if the item is allowed."""
        target = item.ItemToMonitor
        try:
            self._attributes.check_named(target)
            self._attributes.check_encoding(target)
            if target.IndexRange:
                parse_ranges(target.IndexRange)
        except BadStatusError as error:
            return error.code
        except ValueError:
            return "BadIndexRangeInvalid"
        return self._filter_refusal(target, item.RequestedParameters.Filter)

    def _filter_refusal(self, target: Any, item_filter: Any) -> str:
        """Return the name of the status that refuses a filter, or "" if the filter is allowed.

        Values can have a data change filter, with an absolute deadband if they are single numbers.
        """
        kind = type(item_filter).__name__  # asyncua decodes some filters as its own classes
        if target.AttributeId == ua.AttributeIds.EventNotifier:
            return "" if kind == "EventFilter" else "BadEventFilterInvalid"
        if item_filter is None or (kind == "ExtensionObject" and item_filter.TypeId.is_null()):
            return ""
        if target.AttributeId != ua.AttributeIds.Value or kind == "EventFilter":
            return "BadFilterNotAllowed"
        if kind != "DataChangeFilter":
            return "BadMonitoredItemFilterUnsupported"
        if item_filter.DeadbandType == ua.DeadbandType.None_:
            return ""
        tag = self._attributes.tag_of(target)
        if tag is None or tag.variable.type_name in ("BOOL", "STRING"):
            return "BadFilterNotAllowed"
        is_simple = item_filter.DeadbandType == ua.DeadbandType.Absolute and not tag.variable.dims
        return "" if is_simple else "BadMonitoredItemFilterUnsupported"


class _Shape:
    """A callback that cuts values to the requested range and timestamps before a subscription gets them.

    Attributes:
        timestamps: requested timestamps of the items that are being created.
    """

    def __init__(self, service: Any, attributes: Attributes) -> None:
        self._service, self._attributes = service, attributes
        self._pass: Callable[..., Awaitable[None]] = service.datachange_callback
        self.timestamps: Any = None

    async def __call__(self, handle: int, value: Any, error: Any = None) -> None:
        item = self._service._monitored_items[self._service._monitored_datachange[handle]]
        timestamps = getattr(item, "timestamps", self.timestamps)
        shaped = value if error else self._attributes.shaped(value, item.read_value_id, timestamps)
        await self._pass(handle, shaped, error)


def _shape(service: Any, attributes: Attributes) -> _Shape:
    """Return the shaper for a subscription's values, and install it at the first call."""
    callback = service.datachange_callback
    if not isinstance(callback, _Shape):
        callback = service.datachange_callback = _Shape(service, attributes)
    return callback
