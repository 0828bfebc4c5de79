"""Keeps the panel of a rack on disk or of a recording, describes it for pages, and saves it for them."""

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
from .panel_file import ALWAYS, COLUMNS, FIELDS, KINDS, Json, Panel, panel_text, parse_panel, refusals

BYTES_MOST = 60_000
"""Largest size of a panel file, bytes: a page saves it in one message."""

OWN = FileKind("an operator panel", lambda _content: True)  # `save` compares all of it

EDITING = {
    "columns": COLUMNS,
    "allowed": {key: allowed for key, (_, allowed) in FIELDS.items()},
    "kinds": {
        name: {
            "title": kind.title,
            "size": kind.size,
            "needs": [*ALWAYS[:3], *kind.needs],
            "may": kind.may,
        }
        for name, kind in KINDS.items()
    },
}
"""The data that a page needs to build a panel."""


def stamp_of(path: Path) -> tuple[int, int] | None:
    """Return the time and the size of a file, by which a change is seen; None for a missing one."""
    try:
        stat = path.stat()
    except OSError:
        return None
    return stat.st_mtime_ns, stat.st_size


class KeptPanel:
    """The file of an operator panel.

    Args:
        rack: address of the rack file beside it, or the rack file's name in a recording.
        given: the contents in a recording; None = the file on disk.
    """

    def __init__(self, rack: str, given: bytes | None = None) -> None:
        self._path, self._given = Path(panel_name(rack)), given
        self._seen = stamp_of(self._path)

    def changed(self) -> bool:
        """Return whether the file has changed since the last call."""
        before, self._seen = self._seen, stamp_of(self._path)
        return self._given is None and self._seen != before

    def content(self) -> bytes:
        """Return the contents, empty for a missing file; raise ValueError if it can't be read."""
        try:
            content = read_input(self._path, BYTES_MOST) if self._given is None else self._given
        except FileNotFoundError:
            return b""
        except OSError as error:
            raise ValueError(f"it can't be read: {error.strerror}") from error
        if len(content) > BYTES_MOST:
            raise ValueError(f"{len(content):,} bytes: a panel has up to {BYTES_MOST:,}")
        return content

    @property
    def units(self) -> Mapping[str, str]:
        """The units of tags, by name in upper case; empty while the file has a mistake."""
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
            return empty | {
                "mistake": f"{self._path.name}: {error}",
                "lacks": lacks or "fix the file first",
            }
        bound = [bindings.of(item) for item in panel.items]
        fields = {"base": _digest(content), "head": panel.head, "items": panel.items, "bound": bound}
        return empty | fields | {"mistake": "", "lacks": lacks}

    def save(self, panel: Mapping[str, Any]) -> None:
        """Write the items of a page to the file.

        Raises:
            ValueError: an item is refused, or the file has changed since the page read it; it is not
                replaced.
        """
        for refusal in refusals(panel.get("items")).values():
            raise ValueError(refusal)
        content, name = self.content(), self._path.name
        if _digest(content) != panel.get("base"):
            raise ValueError(f"{name} was changed meanwhile: discard your changes, then edit again")
        text = panel_text(Panel(panel["items"], parse_panel(content.decode()).head))
        if len(text.encode()) > BYTES_MOST:
            raise ValueError(f"{name}: {len(text.encode()):,} bytes: a panel has up to {BYTES_MOST:,}")
        try:
            with new_file(self._path, OWN) as file:
                file.write(text)
        except OSError as error:
            raise ValueError(f"{name} can't be written: {error.strerror}") from error


def drafted(items: object, bindings: Bindings) -> Json:
    """Return the bindings of the items that a page edits, with the mistake in each, "" for none."""
    mistakes = refusals(items)
    assert isinstance(items, list)
    empty = {"read": "", "type": ""}
    bound = [
        empty | {"broken": mistakes[place]} if place in mistakes else bindings.of(item)
        for place, item in enumerate(items)
    ]
    return {"bound": bound}


def _digest(content: bytes) -> str:
    return sha256(content).hexdigest() if content else ""
