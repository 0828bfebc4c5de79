"""The attribute services of the OPC UA server: Read, and the operations of Write [OPC UA part 4, 5.11].

For a Read, asyncua (2.1) only returns attributes of existing nodes. It accepts any maximum age and any kind
of timestamps, returns all timestamps, and supports neither index ranges nor data encodings. This module
checks each row of the tables of result codes:

    Read, service       BadNothingToDo, BadTooManyOperations: `opcua_services.py`
                        BadMaxAgeInvalid, BadTimestampsToReturnInvalid
    Read, operation     BadNodeIdInvalid, BadNodeIdUnknown, BadAttributeIdInvalid, BadDataEncodingInvalid,
                        BadDataEncodingUnsupported, BadIndexRangeInvalid, BadIndexRangeNoData; every node has
                        a readable value
    Write, operation    BadNodeIdInvalid, BadNodeIdUnknown, BadAttributeIdInvalid, BadIndexRangeInvalid,
                        BadNotWritable, BadWriteNotSupported, BadTypeMismatch, BadIndexRangeNoData,
                        BadIndexRangeDataMismatch, BadOutOfRange
"""

from __future__ import annotations

from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any

from ..tag_servers.index_ranges import MismatchError, NoDataError, parse_ranges, part_of, shape_of
from ..tag_servers.tag_snapshot import Operation
from ..tag_servers.variables import Variable
from .opcua_library import service_error, status, ua
from .opcua_space import TYPES, TagNode, TagSpace

BINARY = "Default Binary"
ENCODINGS = (BINARY, "Default XML", "Default JSON")
"""OPC UA encodings. Values use the first one."""

FIRST_YEAR = 1601
"""Year in which OPC UA time begins [OPC UA part 6, 5.2.2.5]."""


class BadStatusError(ValueError):
    """A refused operation.

    Attributes:
        code: name of its status code.
    """

    def __init__(self, code: str) -> None:
        super().__init__(code)
        self.code = code


_REFUSALS: Mapping[type[Exception], str] = {
    NoDataError: "BadIndexRangeNoData",
    MismatchError: "BadIndexRangeDataMismatch",
    TypeError: "BadTypeMismatch",
    ValueError: "BadOutOfRange",  # including text with characters that a tag can't store
}
"""Status code of a refused write, by class of the variable's error; the first match applies."""


class Attributes:
    """Reads and writes the attributes that requests name.

    Args:
        space: asyncua's address space.
        tags: the nodes of tags.
    """

    def __init__(self, space: Any, tags: TagSpace) -> None:
        self._space, self._tags = space, tags
        stamps = ua.TimestampsToReturn
        self._both_timestamps = stamps.Both
        self._with_source, self._with_server = (stamps.Source, stamps.Both), (stamps.Server, stamps.Both)

    def tag_of(self, item: Any) -> TagNode | None:
        """Return the tag if a request names the value attribute of a tag, otherwise None."""
        is_value = item.AttributeId == ua.AttributeIds.Value
        return self._tags.nodes.get(item.NodeId) if is_value else None

    def check_timestamps(self, timestamps: Any) -> None:
        """Refuse a request with an unknown kind of timestamps."""
        if timestamps == ua.TimestampsToReturn.Invalid:
            raise service_error("BadTimestampsToReturnInvalid")

    def check_read(self, params: Any) -> None:
        """Refuse an invalid Read request as a whole."""
        if not params.MaxAge >= 0:
            raise service_error("BadMaxAgeInvalid")
        self.check_timestamps(params.TimestampsToReturn)

    # --- reading

    def read(self, params: Any) -> list[Any]:
        """Return the requested values. Call this after reading the tags from the scan process."""
        now = datetime.now(UTC)
        return [self._read(node, params.TimestampsToReturn, now) for node in params.NodesToRead]

    def _read(self, item: Any, timestamps: Any, now: datetime) -> Any:
        """Return the value of a requested attribute, or a bad status in its place."""
        try:
            self.check_named(item)
            self.check_encoding(item)
        except BadStatusError as error:
            return self._stamped(self._bad(error.code), item, timestamps, now)
        value = self._space.read_attribute_value(item.NodeId, item.AttributeId)
        return self.shaped(value, item, timestamps, now)

    def shaped(self, value: Any, item: Any, timestamps: Any, now: datetime | None = None) -> Any:
        """Return a value, cut to the requested range, with the requested timestamps.

        Args:
            item: the attribute, with an optional index range.
        """
        if item.IndexRange and value.Value is not None and value.StatusCode.is_good():
            try:
                value = self._part_of(value, item.IndexRange)
            except NoDataError:
                value = self._bad("BadIndexRangeNoData", value)
            except ValueError:
                value = self._bad("BadIndexRangeInvalid", value)
        return self._stamped(value, item, timestamps, now)

    def _part_of(self, value: Any, text: str) -> Any:
        """Return the part of a value in an index range; raise a ValueError for an invalid range."""
        variant = value.Value
        rank = len(variant.Dimensions) if variant.Dimensions else int(variant.is_array)
        selected = part_of(variant.Value, parse_ranges(text), rank)
        dims = shape_of(selected)[:rank] if rank > 1 else None
        part_variant = ua.Variant(selected, variant.VariantType, dims, bool(rank))
        return ua.DataValue(part_variant, value.StatusCode, value.SourceTimestamp, value.ServerTimestamp)

    def _bad(self, code: str, value: Any = None) -> Any:
        """Return a bad status in place of a value, with the value's timestamps."""
        times = () if value is None else (value.SourceTimestamp, value.ServerTimestamp)
        return ua.DataValue(None, status(code), *times)

    def _stamped(self, value: Any, item: Any, timestamps: Any, now: datetime | None) -> Any:
        """Return a value with the requested timestamps; only values have a source timestamp."""
        is_value = item.AttributeId == ua.AttributeIds.Value
        source, server = value.SourceTimestamp, value.ServerTimestamp
        if is_value and timestamps == self._both_timestamps and source is not None and server is not None:
            return value
        now = now or datetime.now(UTC)
        has_source = is_value and timestamps in self._with_source
        if has_source and source is None and value.StatusCode.is_good():
            source = now
        return ua.DataValue(
            value.Value,
            value.StatusCode,
            source if has_source else None,
            (server or now) if timestamps in self._with_server else None,
        )

    # --- checks of a request

    def check_named(self, item: Any) -> None:
        """Refuse an attribute that does not exist."""
        if item.NodeId.is_null():
            raise BadStatusError("BadNodeIdInvalid")
        node = self._space.get(item.NodeId)
        if node is None:
            raise BadStatusError("BadNodeIdUnknown")
        if item.AttributeId not in node.attributes:
            raise BadStatusError("BadAttributeIdInvalid")

    def check_encoding(self, item: Any) -> None:
        """Refuse an encoding that values do not use."""
        encoding = item.DataEncoding
        if not encoding.Name:
            return
        is_value = item.AttributeId == ua.AttributeIds.Value
        if not is_value or encoding.NamespaceIndex or encoding.Name not in ENCODINGS:
            raise BadStatusError("BadDataEncodingInvalid")
        if encoding.Name != BINARY:
            raise BadStatusError("BadDataEncodingUnsupported")

    # --- writing

    def changes(self, item: Any) -> list[Operation]:
        """Return the operations that write a value.

        Raises:
            BadStatusError: the write is not allowed.
        """
        self.check_named(item)
        node = self.tag_of(item)
        try:
            ranges = parse_ranges(item.IndexRange) if item.IndexRange else None
        except ValueError as error:
            raise BadStatusError("BadIndexRangeInvalid") from error
        if node is None or not node.variable.writable:
            raise BadStatusError("BadNotWritable")
        variable = node.variable
        value = self._value_in(item.Value, variable, is_part=ranges is not None)
        try:
            if ranges is None:
                return [variable.change_to(value)]
            return list(variable.part_to(ranges, value, node.data or bytes(variable.size)))
        except tuple(_REFUSALS) as error:
            code = next(code for kind, code in _REFUSALS.items() if isinstance(error, kind))
            raise BadStatusError(code) from error

    def _value_in(self, data_value: Any, variable: Variable, *, is_part: bool) -> Any:
        """Return the value to write; refuse it if its type is not the variable's type."""
        kinds, variant = ua.VariantType, data_value.Value
        has_value = variant is not None and variant.VariantType != kinds.Null
        if _sets_more(data_value, has_value=has_value):
            raise BadStatusError("BadWriteNotSupported")
        kind, rank = kinds[TYPES[variable.type_name]], len(variable.dims)
        if not has_value or variant.Value is None:
            raise BadStatusError("BadTypeMismatch")
        value, dimensions = variant.Value, len(variant.Dimensions or ()) or int(variant.is_array)
        if variant.VariantType == kinds.ByteString and kind == kinds.Byte and rank == 1 and not dimensions:
            return list(value)
        # a part may have fewer dimensions than the variable, such as one row of a table
        if variant.VariantType != kind or dimensions > rank or (dimensions < rank and not is_part):
            raise BadStatusError("BadTypeMismatch")
        return value


def _sets_more(data_value: Any, *, has_value: bool) -> bool:
    """Return whether a write sets a status or a timestamp.

    A source timestamp with a value is ignored: asyncua's client always sends one, but the server uses the
    time of the scan.
    """
    if data_value.StatusCode is not None and data_value.StatusCode.value:
        return True
    sets_source_time = _is_time(data_value.SourceTimestamp) and not has_value
    return sets_source_time or _is_time(data_value.ServerTimestamp)


def _is_time(stamp: datetime | None) -> bool:
    """Return whether there is a timestamp; the first instant of OPC UA, in 1601, means none."""
    return stamp is not None and stamp.year > FIRST_YEAR
