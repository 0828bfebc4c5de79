"""Host and port of a TCP address as text, with IPv6 in brackets: `localhost:502`, `[::1]:502`.

Without brackets the port follows the last colon: `::1:502` is port 502 of `::1`.
"""

from __future__ import annotations

import re

HIGHEST_PORT = 65_535

_ADDRESS = re.compile(r"(?:\[(?P<v6>[0-9A-Fa-f:.%\w]+)\]:|(?P<host>[^\[\]\s]*):)?(?P<port>[0-9]+)", re.ASCII)


def split_address(text: str) -> tuple[str, int]:
    """Return the host and port; the host is "" if the text is only a port.

    >>> split_address("plc:502"), split_address("[::1]:502"), split_address("502")
    (('plc', 502), ('::1', 502), ('', 502))

    Raises:
        ValueError: the text is not an address.
    """
    match = _ADDRESS.fullmatch(text)
    if match is None or int(match["port"]) > HIGHEST_PORT:
        allowed = f"must be HOST:PORT or PORT, with a port of 0 to {HIGHEST_PORT}"
        raise ValueError(f"{text}: {allowed}; IPv6 needs brackets, as in [::1]:502")
    return match["v6"] or match["host"] or "", int(match["port"])


def join_address(host: str, port: int) -> str:
    """Join a host and a port into one text; this is the inverse of `split_address`.

    >>> join_address("::1", 502), join_address("plc", 502)
    ('[::1]:502', 'plc:502')
    """
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
