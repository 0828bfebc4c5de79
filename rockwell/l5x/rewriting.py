"""Edits of rungs in an L5X; all other elements stay as Studio 5000 has written them.

The file is imported there like the one it was made of: rungs have their numbers, comments of rungs that
stay are kept, and new tags are base tags of their program.
"""

from __future__ import annotations

from codecs import BOM_UTF8
from collections.abc import Iterable, Sequence
from typing import Any

from lxml import etree

from ...ladder.lowering.edited import BEFORE_FIRST, NewTag, RungEdit
from ...ladder.model.errors import LadderError
from ...ladder.model.tags import program_of
from .edits import NORMAL
from .xml.parsing import whole_tree


def rewritten_l5x(data: bytes, edits: Iterable[RungEdit], tags: Sequence[NewTag] = ()) -> bytes:
    """Return an L5X with edited rungs and new tags.

    Args:
        data: an L5X that can be read, see `xml.document`.
        edits: their texts are in the program's notation, see `EditedProgram`.

    Raises:
        LadderError: the file can't be read, has no such rung or program, or a routine has online edits of
            its own.
    """
    root = whole_tree(data)
    by_routine: dict[str, list[RungEdit]] = {}
    for each in edits:
        by_routine.setdefault(each.routine, []).append(each)
    for routine, own in by_routine.items():
        _rewrite(_routine(root, routine), routine, own)
    for tag in tags:
        _declare(_named(root, "Programs/Program", tag.program, alone=True), tag)
    tree = root.getroottree()
    encoding = tree.docinfo.encoding or "UTF-8"
    written = etree.tostring(
        tree, xml_declaration=True, encoding=encoding, standalone=tree.docinfo.standalone
    )
    if data.startswith(BOM_UTF8) and encoding.upper() == "UTF-8":
        written = BOM_UTF8 + written
    return written.replace(b"\n", b"\r\n") if b"\r\n" in data else bytes(written)


def _routine(root: Any, name: str) -> Any:
    program = _named(root, "Programs/Program", program_of(name), alone=True)
    return _named(program, "Routines/Routine", name.rpartition(".")[2])


def _named(parent: Any, path: str, name: str, *, alone: bool = False) -> Any:
    """Return the element with a name; without a name the only one."""
    found = parent.findall(path if parent.tag != "RSLogix5000Content" else f"Controller/{path}")
    for each in found:
        if each.get("Name", "").upper() == name.upper() or (alone and not name and len(found) == 1):
            return each
    raise LadderError(f"the file has no {path.rpartition('/')[2].lower()} {name}")


def _rewrite(routine: Any, name: str, edits: Sequence[RungEdit]) -> None:
    content = routine.find("RLLContent")
    rungs = [] if content is None else content.findall("Rung")
    if any(each.get("Type", NORMAL).upper() != NORMAL for each in rungs):
        raise LadderError(f"routine {name} has online edits in the file: finalize them in Studio 5000 first")
    if content is None:
        content = etree.SubElement(routine, "RLLContent")
    for edit in sorted(edits, key=lambda each: each.rung, reverse=True):
        if not BEFORE_FIRST <= edit.rung < len(rungs):
            raise LadderError(f"routine {name} has no rung {edit.rung} in the file")
        texts, at = list(edit.texts), 0
        if edit.rung != BEFORE_FIRST:
            rung = rungs[edit.rung]
            at = content.index(rung)
            if texts:
                _say(rung, texts.pop(0))
                at += 1
            else:
                content.remove(rung)
        for place, text in enumerate(texts):
            new = etree.Element("Rung", Number="", Type=NORMAL)
            new.tail = content.text
            _say(new, text)
            content.insert(at + place, new)
    for number, rung in enumerate(content.findall("Rung")):
        rung.set("Number", str(number))


def _say(rung: Any, text: str) -> None:
    found = rung.find("Text")
    (etree.SubElement(rung, "Text") if found is None else found).text = (
        text if "]]>" in text else etree.CDATA(text)
    )


def _declare(program: Any, new: NewTag) -> None:
    tags = program.find("Tags")
    if tags is None:
        tags = etree.Element("Tags")
        program.insert(0, tags)
    tag = etree.SubElement(
        tags,
        "Tag",
        Name=new.name,
        TagType="Base",
        DataType=new.type,
        Constant="false",
        ExternalAccess="Read/Write",
    )
    tag.tail = tags.text
