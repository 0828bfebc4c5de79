"""The panel of a rack, from its file or from a trace; its description for pages, and its changes."""

from __future__ import annotations

from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any

from scanrack.io_images.input_files import read_input
from scanrack.jobs.load.panels import panel_name
from scanrack.traces.files.guard import FileKind
from scanrack.traces.files.newfile import new_file

from .bindings import Bindings
from .panel_file import COLUMNS, FIELDS, KINDS, REQUIRED, Json, Panel, panel_text, parse_panel, refusals

BYTES_MOST = 60_000
"""Maximum size of a panel file in bytes, since a page saves it with one message."""

OWN = FileKind("an operator panel", lambda _content: True)  # `save` compares the contents itself

EDITING = {
    "columns": COLUMNS,
    "allowed": {key: allowed for key, (_, allowed) in FIELDS.items()},
    "kinds": {
        name: {
            "title": kind.title,
            "size": kind.size,
            "needs": [*REQUIRED[:3], *kind.needs],
            "may": kind.optional,
        }
        for name, kind in KINDS.items()
    },
}
"""The rules for panels, sent to a page that edits one."""


def stamp_of(path: Path) -> tuple[int, int] | None:
    """Return the time and size of a file, to detect a new version; None for a missing file."""
    try:
        stat = path.stat()
    except OSError:
        return None
    return stat.st_mtime_ns, stat.st_size


class KeptPanel:
    """The file of an operator panel.

    Args:
        rack: path of the rack file, or the rack file's name in a trace.
        recorded: the contents in a trace; None = the file on disk.
    """

    def __init__(self, rack: str, recorded: bytes | None = None) -> None:
        self._path, self._recorded = Path(panel_name(rack)), recorded
        self._stamp = stamp_of(self._path)

    def changed(self) -> bool:
        """Return whether the file has changed since the last call."""
        previous, self._stamp = self._stamp, stamp_of(self._path)
        return self._recorded is None and self._stamp != previous

    def content(self) -> bytes:
        """Return the contents, empty for a missing file; raise ValueError if the file can't be read."""
        try:
            content = read_input(self._path, BYTES_MOST) if self._recorded is None else self._recorded
        except FileNotFoundError:
            return b""
        except OSError as error:
            raise ValueError(f"it can't be read: {error.strerror}") from error
        if len(content) > BYTES_MOST:
            raise ValueError(f"{len(content):,} bytes: must be at most {BYTES_MOST:,}")
        return content

    @property
    def units(self) -> Mapping[str, str]:
        """The units of tags, by tag name in upper case; empty while the file has a mistake."""
        try:
            items = parse_panel(self.content().decode()).items
        except ValueError:
            return {}
        return {item["tag"].upper(): item["unit"] for item in items if item.get("unit")}

    def described(self, bindings: Bindings, lacks: str) -> Json:
        """Return the panel for a page.

        Args:
            lacks: why a page can't save it; "" if it can.
        """
        empty: Json = {"file": self._path.name, "base": "", "head": [], "items": [], "bound": [], **EDITING}
        try:
            content = self.content()
            panel = parse_panel(content.decode())
        except ValueError as error:
            return empty | {"mistake": f"{self._path.name}: {error}", "lacks": lacks or "fix the file first"}
        bound = list(map(bindings.binding_of, panel.items))
        fields = {"base": _digest(content), "head": panel.head, "items": panel.items, "bound": bound}
        return empty | fields | {"mistake": "", "lacks": lacks}

    def save(self, panel: Mapping[str, Any]) -> None:
        """Write the items from a page to the file.

        Raises:
            ValueError: an item is not allowed, or the file has changed since the page read it; the file is
                unchanged.
        """
        for refusal in refusals(panel.get("items")).values():
            raise ValueError(refusal)
        content, name = self.content(), self._path.name
        if _digest(content) != panel.get("base"):
            raise ValueError(f"{name} was changed meanwhile: discard your changes, then edit again")
        text = panel_text(Panel(panel["items"], parse_panel(content.decode()).head))
        if len(text.encode()) > BYTES_MOST:
            raise ValueError(f"{name}: {len(text.encode()):,} bytes: must be at most {BYTES_MOST:,}")
        try:
            with new_file(self._path, OWN) as file:
                file.write(text)
        except OSError as error:
            raise ValueError(f"{name} can't be written: {error.strerror}") from error


def drafted(items: object, bindings: Bindings) -> Json:
    """Return the bindings of items that a page edits; `broken` is the mistake in an item, or ""."""
    mistakes = refusals(items)
    assert isinstance(items, list)
    empty = {"read": "", "type": ""}
    bound = [
        empty | {"broken": mistakes[index]} if index in mistakes else bindings.binding_of(item)
        for index, item in enumerate(items)
    ]
    return {"bound": bound}


def _digest(content: bytes) -> str:
    return sha256(content).hexdigest() if content else ""
