#!/usr/bin/env bash
# What: asyncua's DataChangeFilter has the trigger Status, not StatusValue as its source says, and decodes as another class
# Packages:
#   pypi asyncua 2.1.0
# Date: 2026-11-29
# Meets: who subscribes with a deadband
# Expected: StatusValue, the default of Part 4, 7.22.2; and isinstance holds after decoding
# Behavior:
#   The class in uaprotocol_hand has the comment Default is StatusValue and a class attribute without annotation, which is no
#   field of a dataclass: a new filter has Trigger Status, so a strict server reports no change of the value. A decoded filter
#   is of the generated class of the same name, and isinstance with ua.DataChangeFilter is False.
# Scanrack: Its OPC UA server takes filters of both classes: see [clients of the tag servers](hmi-clients.md)
# Output:
. "$(dirname "$0")/lib.sh"
observe python - <<'PY'
from asyncua import ua
from asyncua.common.utils import Buffer
from asyncua.ua.ua_binary import extensionobject_from_binary, extensionobject_to_binary

new = ua.DataChangeFilter(DeadbandType=1, DeadbandValue=0.5)
read = extensionobject_from_binary(Buffer(extensionobject_to_binary(new)))
print("new:", ua.DataChangeTrigger(new.Trigger).name, "class attribute:", ua.DataChangeFilter.__dict__.get("Trigger"))
print("read:", read.Trigger.name, read.DeadbandType, read.DeadbandValue)
print("same class:", type(read) is ua.DataChangeFilter, "isinstance:", isinstance(read, ua.DataChangeFilter))
PY
