#!/usr/bin/env bash
# what: minimalmodbus sends 28 for 0.29 with two decimals: it truncates the scaled number where it should round
# date: 2026-11-30
# meets: set points of drives and temperature controllers whose registers have fixed decimals
# expected: 29, since 0.29 with two decimals is the register 29
# behavior:
#   write_register multiplies by a power of ten and drops the fraction, so binary floating point makes
#   0.29 x 100 = 28.999... into 28. Six of the seven values below lose a unit of their last digit; writing back
#   the 1.14 that is read for 1.15 makes 113 of 114.
# product: Its clients send whole registers, and the parameter tables state their units: [line clients](line-clients.md)
# output:
#   0.25, 2 decimals: register 25
#   0.29, 2 decimals: register 28
#   0.57, 2 decimals: register 56
#   1.15, 2 decimals: register 114
#   4.35, 2 decimals: register 434
#   -0.29, 2 decimals: register -28
#   1.005, 3 decimals: register 1004
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install minimalmodbus==2.1.1 pyserial==3.5
observe python - <<'PY'
import os
import struct
import threading
import tty

import minimalmodbus

device, line = os.openpty()
tty.setraw(device)
tty.setraw(line)
registers = []


def acknowledge():
    while True:
        request = os.read(device, 64)
        registers.append(struct.unpack(">h", request[7:9])[0])
        checksum = 0xFFFF
        for byte in request[:6]:
            checksum ^= byte
            for _ in range(8):
                checksum = checksum >> 1 ^ (0xA001 if checksum & 1 else 0)
        os.write(device, request[:6] + struct.pack("<H", checksum))


threading.Thread(target=acknowledge, daemon=True).start()
instrument = minimalmodbus.Instrument(os.ttyname(line), 1)
instrument.serial.timeout = 2
for number, decimals in ((0.25, 2), (0.29, 2), (0.57, 2), (1.15, 2), (4.35, 2), (-0.29, 2), (1.005, 3)):
    instrument.write_register(0, number, decimals, signed=True)
    print(f"{number}, {decimals} decimals: register {registers[-1]}")
PY
