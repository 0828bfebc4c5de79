"""Controls access by tables of hosts, origins and headers.

    Host        one of ours              else 421: another name for this address (DNS rebinding)
    Origin      one of ours, or none     else 403: another page
    path        in the table of files    else 404
    key         in the first message     else the socket is closed

There is no cookie, since cookies are not separated by port.
"""

from __future__ import annotations

import hmac
import os
import socket
from collections.abc import Mapping
from typing import NamedTuple

from .page_files import PageFiles

HOST = "127.0.0.1"
KEY_BYTES = 16
SOCKET = "/socket"

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'{style}; img-src 'self'; connect-src 'self'; "
    "font-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
HEADERS = {
    "Content-Security-Policy": POLICY.format(style=""),
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-cache",
}


def listen(port: int) -> socket.socket:
    """Listen for pages; raise ValueError if the port is in use or not allowed."""
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
        self._origins = [f"http://{host_name}" for host_name in self._hosts]
        self._key = key.encode()
        self._files = PageFiles()

    def answer(
        self, path: str, host: str | None, origin: str | None, *, accepts: str = "", known: str = ""
    ) -> Answer | None:
        """Answer a request; None lets it become a socket.

        Args:
            accepts: the encodings that the browser accepts, from its header Accept-Encoding.
            known: the entity tags of content that it has, from its header If-None-Match.
        """
        if host is None or host.lower() not in self._hosts:
            return _refusal(421, "this server has another name")
        if origin is not None and origin.lower() not in self._origins:
            return _refusal(403, "another page asks")
        path = path.partition("?")[0]
        if path == SOCKET:
            return None
        return self._file("/index.html" if path == "/" else path, accepts, known)

    def _file(self, path: str, accepts: str, known: str) -> Answer:
        file = self._files.get(path)
        if file is None:
            return _refusal(404, "no such file")
        packed = _takes_gzip(accepts)
        coding = "gzip" if packed else "identity"
        tag = f'"{file.digest}-{coding}"'
        headers = {"ETag": tag, "Vary": "Accept-Encoding", **HEADERS}
        if file.style:
            headers["Content-Security-Policy"] = POLICY.format(style=f" 'sha256-{file.style}'")
        if tag in known:
            return Answer(304, headers, b"")
        body = file.packed if packed else file.body
        encoding = {"Content-Encoding": "gzip"} if packed else {}
        return Answer(
            200, {"Content-Type": file.kind, "Content-Length": str(len(body)), **encoding, **headers}, body
        )

    def fits(self, key: object) -> bool:
        """Compare a key with the session's in constant time."""
        return isinstance(key, str) and hmac.compare_digest(key.encode("utf-8", "replace"), self._key)


_LOOPBACK = ("127.0.0.1", "localhost", "::1")


def _takes_gzip(accepts: str) -> bool:
    """Return whether a header Accept-Encoding allows gzip [RFC 9110, section 12.5.3]."""
    offers = {
        name.strip().lower(): parameters
        for name, _, parameters in (coding.partition(";") for coding in accepts.split(","))
    }
    weight = offers.get("gzip", offers.get("*", "q=0")).replace(" ", "").lower()
    return not weight.startswith("q=0") or weight.strip("q=.0") != ""


def _in_url(host: str) -> str:
    return f"[{host}]" if ":" in host else host


def _refusal(status: int, says: str) -> Answer:
    body = f"{says}\n".encode()
    headers = {"Content-Type": "text/plain; charset=utf-8", "Content-Length": str(len(body))}
    return Answer(status, headers | HEADERS, body)
