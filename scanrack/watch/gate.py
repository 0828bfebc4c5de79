"""Access rules for requests from browsers, as tables of hosts, origins and headers.

    Host        one of ours              otherwise 421: another name for this address (DNS rebinding)
    Origin      one of ours, or none     otherwise 403: another site
    path        in the table of files    otherwise 404
    key         in the first message     otherwise the socket is closed

Cookies are not used, since browsers share them between ports.
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
        raise ValueError(f"--port {port}: {text}; choose another port, or omit it for a free one") from error


class Answer(NamedTuple):
    """An answer to a request for a file."""

    status: int
    headers: Mapping[str, str]
    body: bytes


class Gate:
    """Checks requests, and answers them with files."""

    def __init__(self, host: str, port: int, key: str) -> None:
        names = [host] if host not in _LOOPBACK else list(_LOOPBACK)  # any name of this machine
        self._hosts = [f"{_in_url(name)}:{port}" for name in names]
        if port == 80:  # browsers leave it out
            self._hosts += map(_in_url, names)
        self._origins = [f"http://{host_name}" for host_name in self._hosts]
        self._key = key.encode()
        self._files = PageFiles()

    def respond(
        self, path: str, host: str | None, origin: str | None, *, accepts: str = "", cached: str = ""
    ) -> Answer | None:
        """Return the answer to a request; None for a request that may open a socket.

        Args:
            accepts: the encodings that the browser accepts, from its Accept-Encoding header.
            cached: the entity tags of files in the browser's cache, from its If-None-Match header.
        """
        if host is None or host.lower() not in self._hosts:
            return _refusal(421, "unknown host name")
        if origin is not None and origin.lower() not in self._origins:
            return _refusal(403, "requests from other sites are not allowed")
        path = path.partition("?")[0]
        if path == SOCKET:
            return None
        return self._file("/index.html" if path == "/" else path, accepts, cached)

    def _file(self, path: str, accepts: str, cached: str) -> Answer:
        """Return the answer with a file, as gzip if accepted; 304 if it is cached, 404 if it is missing."""
        file = self._files.get(path)
        if file is None:
            return _refusal(404, "no such file")
        is_packed = _accepts_gzip(accepts)
        tag = f'"{file.digest}-{"gzip" if is_packed else "identity"}"'
        headers = {"ETag": tag, "Vary": "Accept-Encoding", **HEADERS}
        if file.style:
            headers["Content-Security-Policy"] = POLICY.format(style=f" 'sha256-{file.style}'")
        if tag in cached:
            return Answer(304, headers, b"")
        body = file.packed if is_packed else file.body
        headers |= {"Content-Type": file.kind, "Content-Length": str(len(body))}
        if is_packed:
            headers["Content-Encoding"] = "gzip"
        return Answer(200, headers, body)

    def is_key(self, text: object) -> bool:
        """Return whether a text is the session's key; the comparison takes constant time."""
        return isinstance(text, str) and hmac.compare_digest(text.encode("utf-8", "replace"), self._key)


_LOOPBACK = ("127.0.0.1", "localhost", "::1")


def _accepts_gzip(accepts: str) -> bool:
    """Return whether an Accept-Encoding header allows gzip [RFC 9110, section 12.5.3]."""
    weights = {}
    for coding in accepts.split(","):
        name, _, parameter = coding.partition(";")
        weights[name.strip().lower()] = parameter
    weight = weights.get("gzip", weights.get("*", "q=0")).replace(" ", "").lower()
    return not weight.startswith("q=0") or weight.strip("q=.0") != ""


def _in_url(host: str) -> str:
    return f"[{host}]" if ":" in host else host


def _refusal(status: int, text: str) -> Answer:
    body = f"{text}\n".encode()
    headers = {"Content-Type": "text/plain; charset=utf-8", "Content-Length": str(len(body))}
    return Answer(status, headers | HEADERS, body)
