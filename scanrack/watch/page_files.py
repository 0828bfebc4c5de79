"""The files of the page, prepared for browsers: all modules in one script, and an inline style sheet.

/              index.html with watch.css in it
/page.js       all modules, see `joining`
/dom.js        for scripts of tests: the names of a module, re-exported from /page.js
"""

from __future__ import annotations

import gzip
from base64 import b64encode
from functools import cached_property
from hashlib import sha256
from importlib.resources import files

from .joining import MAIN, PAGE, PageScript, joined

TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
}
"""Media types of the served files in `web/`, by suffix."""

SOURCE_OF_SHARED_PAGES = "embedded.js"
STYLE_LINK = '<link rel="stylesheet" href="watch.css">'
SCRIPT = f'<script type="module" src="{MAIN}"></script>'


class ServedFile:
    """A file for browsers.

    Attributes:
        kind: media type.
        style: SHA-256 of its inline style in base64; "" without one.
    """

    def __init__(self, body: bytes, kind: str, style: str = "") -> None:
        self.body, self.kind, self.style = body, kind, style

    @cached_property
    def packed(self) -> bytes:
        """The body, compressed with gzip."""
        return gzip.compress(self.body, 9, mtime=0)

    @cached_property
    def digest(self) -> str:
        """A digest that identifies the content."""
        return sha256(self.body).hexdigest()[:32]


class PageFiles:
    """The served files, by path."""

    def __init__(self) -> None:
        self._folder = files(__package__).joinpath("web")
        self._names = {file.name for file in self._folder.iterdir()}
        self._cache: dict[str, ServedFile] = {}

    def get(self, path: str) -> ServedFile | None:
        """Return the file at a path, or None."""
        name, suffix = path.removeprefix("/"), path[path.rfind(".") :]
        exists = path.startswith("/") and (name in self._names or name == PAGE) and suffix in TYPES
        if exists and name not in self._cache:
            self._cache[name] = self._make(name, TYPES[suffix])
        return self._cache[name] if exists else None

    def _make(self, name: str, kind: str) -> ServedFile:
        """Return the file with a name: the index, the joined script, a facade, or another file."""
        if name == "index.html":
            return self._index(kind)
        if name == PAGE:
            return ServedFile(self._joined.script.encode(), kind)
        facade = self._joined.facades.get(name) if name.endswith(".js") else None
        body = self._folder.joinpath(name).read_bytes() if facade is None else facade.encode()
        return ServedFile(body, kind)

    def _index(self, kind: str) -> ServedFile:
        """Return the page with its inline style sheet and the joined script."""
        style = self._text("watch.css")
        text = self._text("index.html").replace(SCRIPT, SCRIPT.replace(MAIN, PAGE))
        text = text.replace(STYLE_LINK, f"<style>{style}</style>")
        return ServedFile(text.encode(), kind, b64encode(sha256(style.encode()).digest()).decode())

    def _text(self, name: str) -> str:
        return self._folder.joinpath(name).read_text(encoding="utf-8")

    @cached_property
    def _joined(self) -> PageScript:
        modules = (name for name in self._names if name.endswith(".js") and name != SOURCE_OF_SHARED_PAGES)
        return joined({module: self._text(module) for module in modules})
