#!/usr/bin/env bash
# what: scapy drops the second Modbus request of a TCP segment, and a packet that it builds again is shorter
# date: 2026-11-30
# meets: captures of masters with several open transactions, analyzed or replayed with scapy
# expected: two ModbusADURequest layers, or the rest of the segment as Raw
# behavior:
#   The dissector of function 03 requests keeps no payload, so the second request is neither a layer nor Raw, and
#   building the packet leaves its 12 bytes out. The responses to both keep the second one as Raw.
# product: Reads every frame of a segment and every segment of a frame: [captures](captures.md)
# output:
#   request: 24 bytes in the segment, layers ModbusADURequest ModbusPDU03ReadHoldingRegistersRequest, built again 12
#   response: 26 bytes in the segment, layers ModbusADUResponse ModbusPDU03ReadHoldingRegistersResponse Raw, built again 26
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install scapy==2.8.0
observe python - <<'PY'
from scapy.contrib.modbus import ModbusADURequest, ModbusADUResponse
from scapy.layers.inet import IP, TCP
from scapy.packet import Raw

PORTS = {"request": (40000, 502), "response": (502, 40000)}
ADUS = {
    "request": ("000100000006010300000002", "000200000006010300100002"),
    "response": ("00010000000701030400010002", "00020000000701030400030004"),
}
for name, (source, target) in PORTS.items():
    sent = bytes.fromhex("".join(ADUS[name]))
    segment = IP(src="127.0.0.1", dst="127.0.0.1") / TCP(sport=source, dport=target, flags="PA") / Raw(sent)
    payload = IP(bytes(segment))[TCP].payload
    layers = " ".join(layer.__name__ for layer in payload.layers())
    print(f"{name}: {len(sent)} bytes in the segment, layers {layers}, built again {len(bytes(payload))}")
PY
