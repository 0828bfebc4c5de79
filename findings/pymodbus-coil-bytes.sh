#!/usr/bin/env bash
# what: pymodbus 3.10.0 reverses the bytes of more than eight coils, in requests, answers and when it reads
# date: 2026-11-29
# meets: anyone who pins that version between a client and a device of another make
# expected: the first eight coils in the first byte, as the Modbus specification says (6.1, 6.11)
# behavior:
#   Coils 0 to 3 of twelve are on. The specification's bytes are 0F 00. Version 3.10.0 writes 00 0F and reads 0F 00 as
#   coils 8 to 11, so two programs with it agree with each other and with no device. 3.16.1 writes and reads 0F 00.
# product: Requires pymodbus 3.15 or later; see [Modbus](hmi.md#modbus)
# output:
#   answer to 01h: 02 00 0f
#   request 0Fh: 00 00 00 10 02 00 0f
#   0f 00 read as coils [8, 9, 10, 11]
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install pymodbus==3.10.0
observe python - <<'PY'
from pymodbus.pdu import DecodePDU
from pymodbus.pdu.bit_message import ReadCoilsResponse, WriteMultipleCoilsRequest

coils = [True] * 4 + [False] * 8
print("answer to 01h:", ReadCoilsResponse(bits=coils).encode().hex(" "))
print("request 0Fh:", WriteMultipleCoilsRequest(address=0, bits=coils).encode().hex(" "))
read = DecodePDU(False).decode(bytes.fromhex("01 02 0f 00")).bits
print("0f 00 read as coils", [number for number, on in enumerate(read) if on])
PY
