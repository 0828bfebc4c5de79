#!/usr/bin/env bash
# what: asyncua's DataChangeFilter has the trigger Status, not StatusValue as its source says, and decodes as another class
# date: 2026-11-29
# meets: anyone who subscribes with a deadband
# expected: StatusValue, as its comment says; and isinstance holds after decoding
# behavior:
#   The class in uaprotocol_hand has the comment Default is StatusValue and a class attribute without annotation, which is
#   no default of a dataclass: a new filter has the trigger Status, which stands for changes of the status alone. A decoded
#   filter is of the generated class of the same name, and isinstance with ua.DataChangeFilter is False.
# product: Its OPC UA server recognizes a filter by the name of its class; see [OPC UA](hmi.md#opc-ua)
# output:
#   new: Status
#   read: Status 1 0.5
#   same class: False isinstance: False
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install asyncua==2.1.0
observe python - <<'PY'
from asyncua import ua
from asyncua.common.utils import Buffer
from asyncua.ua.ua_binary import extensionobject_from_binary, extensionobject_to_binary

new = ua.DataChangeFilter(DeadbandType=1, DeadbandValue=0.5)
read = extensionobject_from_binary(Buffer(extensionobject_to_binary(new)))
print("new:", ua.DataChangeTrigger(new.Trigger).name)
print("read:", read.Trigger.name, read.DeadbandType, read.DeadbandValue)
print("same class:", type(read) is ua.DataChangeFilter, "isinstance:", isinstance(read, ua.DataChangeFilter))
PY
