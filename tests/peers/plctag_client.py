"""Reads and writes tags with libplctag, a library in C, and prints what it got.

    python plctag_client.py LIBRARY PORT controllogix NAME[=VALUE] ...
    python plctag_client.py LIBRARY PORT micrologix NAME[=VALUE] ...

A name may say how many elements it means: `Dints{3000}`. Prints the first value and the bytes of each, of
listings (`@tags`, `@udt/256`) all bytes as hexadecimal, or the library's word for what went wrong.
"""

from __future__ import annotations

import ctypes
import json
import sys
from typing import Any

TIMEOUT_MS = 120_000
PATHS = {"controllogix": "&path=1,0", "micrologix": ""}


def main(path: str, port: str, plc: str, *wanted: str) -> None:
    library = ctypes.CDLL(path)
    library.plc_tag_decode_error.restype = ctypes.c_char_p
    library.plc_tag_get_int16.restype = ctypes.c_int16
    library.plc_tag_get_uint8.restype = ctypes.c_uint8

    def word(status: int) -> str:
        return str(library.plc_tag_decode_error(status).decode())

    def answer(text: str) -> Any:
        name, _, value = text.partition("=")
        name, _, count = name.partition("{")
        where = f"protocol=ab-eip&gateway=127.0.0.1:{port}&plc={plc}{PATHS[plc]}"
        tag = library.plc_tag_create(
            f"{where}&elem_count={count.rstrip('}') or 1}&name={name}".encode(), TIMEOUT_MS
        )
        if tag < 0:
            return word(tag)
        try:
            if (status := library.plc_tag_read(tag, TIMEOUT_MS)) < 0:
                return word(status)
            size = library.plc_tag_get_size(tag)
            if "@" in name:
                return bytes(library.plc_tag_get_uint8(tag, at) for at in range(size)).hex()
            bit = library.plc_tag_get_bit(tag, 0) if name.rpartition(".")[2].isdecimal() else -1
            if value:
                width = min(4, size)
                put = library.plc_tag_set_int16 if width == 2 else library.plc_tag_set_int32
                for at in range(0, size, width):
                    put(tag, at, int(value))
                if (status := library.plc_tag_write(tag, TIMEOUT_MS)) < 0:
                    return word(status)
                library.plc_tag_read(tag, TIMEOUT_MS)
            if bit >= 0:
                return bool(bit)
            get = library.plc_tag_get_int16 if size == 2 else library.plc_tag_get_int32
            return [get(tag, 0), size]
        finally:
            library.plc_tag_destroy(tag)

    sys.stdout.write(json.dumps({each: answer(each) for each in wanted}))


if __name__ == "__main__":
    main(*sys.argv[1:])
