#!/usr/bin/env bash
# what: none of libmodbus's four named float orders reads back what it wrote
# date: 2026-11-29
# meets: anyone who exchanges REAL values with a program linked against Debian 12's libmodbus
# expected: modbus_get_float_X is the inverse of modbus_set_float_X, and abcd is 47f1 2000 for 123456.0
# behavior:
#   modbus_get_float_abcd reads 47f1 2000 as 123456, as documented. modbus_set_float_abcd writes f147 0020: the bytes of
#   each register are swapped, in all four setters. Only the unnamed pair, modbus_set_float and modbus_get_float, is its own inverse.
# product: A REAL is two registers in the order of the row or of `order`: use libmodbus's unnamed pair with `low first`; see [Modbus](hmi.md#modbus)
# output:
#   set_float_abcd(123456.0): f147 0020 reads back as another number
#   set_float_dcba(123456.0): 2000 47f1 reads back as another number
#   set_float_badc(123456.0): 47f1 2000 reads back as another number
#   set_float_cdab(123456.0): 0020 f147 reads back as another number
#   set_float(123456.0): 2000 47f1 reads back as the same
#   get_float_abcd(47f1 2000): 123456.0
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
# its name and version as dpkg gives them
install libmodbus5=3.1.6-2.1+deb12u1
observe python3 - <<'PY'
import ctypes

library = ctypes.CDLL("libmodbus.so.5")
Registers = ctypes.c_uint16 * 2
for order in ("_abcd", "_dcba", "_badc", "_cdab", ""):
    write = getattr(library, f"modbus_set_float{order}")
    write.argtypes = [ctypes.c_float, ctypes.POINTER(ctypes.c_uint16)]
    read = getattr(library, f"modbus_get_float{order}")
    read.restype = ctypes.c_float
    registers = Registers()
    write(123456.0, registers)
    back = "the same" if read(registers) == 123456.0 else "another number"
    print(f"set_float{order}(123456.0):", " ".join(f"{each:04x}" for each in registers), "reads back as", back)
library.modbus_get_float_abcd.restype = ctypes.c_float
print("get_float_abcd(47f1 2000):", library.modbus_get_float_abcd(Registers(0x47F1, 0x2000)))
PY
