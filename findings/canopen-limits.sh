#!/usr/bin/env bash
# what: a canopen node accepts a value beyond the HighLimit of its EDS, and silently drops the fraction of a number
# date: 2026-11-30
# meets: anyone who tests a master's set points against a simulated CiA 402 drive
# expected: SDO abort 06090031h (value too high), as a drive answers, and an error for 1.9 into an INTEGER32
# behavior:
#   Both ends know the limit. The master logs a warning and sends the value; the node stores it and confirms the transfer.
# product: Its networked drives refuse what is out of range with the bits of their manual: [networked drives](drives.md)
# output:
#   limits -1000 to 1000
#   1000: 1000
#   2000: 2000
#   1.9: 1
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install canopen==2.4.1 python-can==4.6.1
observe python - <<'PY'
import logging

import canopen
from canopen.objectdictionary import INTEGER32, ObjectDictionary, ODVariable

logging.disable(logging.CRITICAL)
target = ODVariable("target position", 0x607A)
target.data_type, target.access_type, target.min, target.max = INTEGER32, "rw", -1000, 1000
objects = ObjectDictionary()
objects.add_object(target)
master, slave = canopen.Network(), canopen.Network()
for network in (master, slave):
    network.connect(interface="virtual", channel="canopen-limits")
slave.create_node(5, objects)
drive = master.add_node(5, objects)
print(f"limits {target.min} to {target.max}")
for value in (1000, 2000, 1.9):
    drive.sdo[0x607A].raw = value
    print(f"{value}: {drive.sdo[0x607A].raw}")
master.disconnect()
slave.disconnect()
PY
