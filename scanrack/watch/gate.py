"""Access: hosts, origins, files and headers, as tables.

    Host        one of ours              else 421: another name for this address (DNS rebinding)
    Origin      one of ours, or none     else 403: another page
    path        in the table             else 404
    key         in the first message     else the socket is closed

No cookie: cookies don't know ports.
"""

from __future__ import annotations

import hmac
import os
import socket
from collections.abc import Mapping
from importlib.resources import files
from typing import NamedTuple

HOST = "127.0.0.1"
KEY_BYTES = 16
SOCKET = "/socket"

TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
    ".png": "image/png",
    ".ico": "image/x-icon",
    ".woff2": "font/woff2",
}
"""Served files of `web/`, by suffix."""

HEADERS = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; "
        "font-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}


def listen(port: int) -> socket.socket:
    """Listen for pages; ValueError if the port is in use, or not allowed."""
    try:
        return socket.create_server((HOST, port))
    except OSError as error:
        text = os.strerror(error.errno) if error.errno else str(error)
        raise ValueError(f"--port {port}: {text}: choose another one, or none for a free one") from error


class Answer(NamedTuple):
    """An answer to a request for a file."""

    status: int
    headers: Mapping[str, str]
    body: bytes


class Gate:
    """Decides about requests, and serves the files."""

    def __init__(self, host: str, port: int, key: str) -> None:
        names = [host] if host not in _LOOPBACK else list(_LOOPBACK)
        self._hosts = [f"{_in_url(name)}:{port}" for name in names]
        if port == 80:
            self._hosts += map(_in_url, names)
        self._origins = [f"http://{each}" for each in self._hosts]
        self._key = key.encode()
        self._files = {f"/{each.name}": each for each in files(__package__).joinpath("web").iterdir()}
        modules = sorted(name for name in self._files if name.endswith(".js") and name != _OF_SHARED_PAGES)
        self._preloads = "".join(f'\n<link rel="modulepreload" href="{each}">' for each in modules).encode()

    def answer(self, path: str, host: str | None, origin: str | None) -> Answer | None:
        """Answer a request; None lets it become a socket."""
        if host is None or host.lower() not in self._hosts:
            return _refusal(421, "this server has another name")
        if origin is not None and origin.lower() not in self._origins:
            return _refusal(403, "another page asks")
        path = path.partition("?")[0]
        if path == SOCKET:
            return None
        return self._file("/index.html" if path == "/" else path)

    def _file(self, path: str) -> Answer:
        file = self._files.get(path)
        kind = TYPES.get(path[path.rfind(".") :])
        if file is None or kind is None:
            return _refusal(404, "no such file")
        body = file.read_bytes()
        if path == "/index.html":
            body = body.replace(_LAST_LINK, _LAST_LINK + self._preloads)
        return Answer(200, {"Content-Type": kind, "Content-Length": str(len(body)), **HEADERS}, body)

    def fits(self, key: object) -> bool:
        """Compare a key with the session's in constant time."""
        return isinstance(key, str) and hmac.compare_digest(key.encode("utf-8", "replace"), self._key)


_LAST_LINK = b'<link rel="stylesheet" href="watch.css">'
"""What the names of all modules stand behind: a browser loads them at once, not import by import."""

_OF_SHARED_PAGES = "/embedded.js"
_LOOPBACK = ("127.0.0.1", "localhost", "::1")


def _in_url(host: str) -> str:
    return f"[{host}]" if ":" in host else host


def _refusal(status: int, says: str) -> Answer:
    body = f"{says}\n".encode()
    head = {"Content-Type": "text/plain; charset=utf-8", "Content-Length": str(len(body))}
    return Answer(status, head | HEADERS, body)
