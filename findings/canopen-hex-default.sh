#!/usr/bin/env bash
# what: canopen reads a signed DefaultValue in hexadecimal without its sign, but LowLimit and HighLimit with it
# date: 2026-11-30
# meets: anyone who simulates a CiA 402 drive from its EDS file
# expected: -5 for FFFFFFFBh in an INTEGER32, as the limits beside it are read
# behavior:
#   The default becomes 4294967291. The object dictionary takes it without a word; only a client that reads the object
#   from a local node gets the abort General error, since the number does not fit the object's type. In decimal, -5, it works.
# product: Its networked drives use EtherNet/IP and Modbus TCP, not CANopen: [networked drives](drives.md)
# output:
#   target position: default 4294967291, limits -2147483648 to 2147483647, read: Code 0x08000000, General error
#   position actual value: default -5, limits -2147483648 to 2147483647, read: -5
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install canopen==2.4.1 python-can==4.6.1
observe python - <<'PY'
import io
import logging

import canopen

logging.disable(logging.CRITICAL)
OBJECT = """[{index}]
ParameterName={name}
ObjectType=0x7
DataType=0x0004
AccessType=rw
DefaultValue={default}
LowLimit=0x80000000
HighLimit=0x7FFFFFFF
PDOMapping=1
"""
eds = io.StringIO(
    "[DeviceInfo]\nVendorName=Sample\n[OptionalObjects]\nSupportedObjects=2\n1=0x607A\n2=0x6064\n"
    + OBJECT.format(index="607A", name="target position", default="0xFFFFFFFB")
    + OBJECT.format(index="6064", name="position actual value", default="-5")
)
eds.name = "drive.eds"
objects = canopen.import_od(eds, 5)
master, slave = canopen.Network(), canopen.Network()
for network in (master, slave):
    network.connect(interface="virtual", channel="canopen-hex-default")
slave.create_node(5, objects)
drive = master.add_node(5, objects)
for index in (0x607A, 0x6064):
    entry = objects[index]
    try:
        read = drive.sdo[index].raw
    except canopen.SdoAbortedError as error:
        read = error
    print(f"{entry.name}: default {entry.default}, limits {entry.min} to {entry.max}, read: {read}")
master.disconnect()
slave.disconnect()
PY
