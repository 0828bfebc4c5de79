"""Why a tag has its value: the chain of causes in the console, each link with its line."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scanrack.ladder.debug.causes import Causes
from scanrack.ladder.debug.chains import Chains
from scanrack.ladder.debug.crossref import CrossReference
from scanrack.ladder.debug.inquiry import Inquiry
from scanrack.ladder.debug.links import said
from scanrack.ladder.model.tree import Origin

from .protocol import DebugError

if TYPE_CHECKING:
    from .adapter import Adapter


def why(adapter: Adapter, tag: str) -> str:
    """Return why a tag has its value after the scan; the links follow, each with its line.

    Raises:
        DebugError: no such tag, or not a single value.
    """
    cursor, subject = adapter.place(), adapter.the_subject()
    scan, spot, places = cursor.scan, cursor.spot, subject.places(cursor.scan)
    engine = cursor.view.engine
    if tag not in engine.tags:
        raise DebugError(f"no tag {tag!r}: write why TAG")
    adapter.leave()
    replayer = subject.replayer(scan)
    try:
        found = Chains(engine.lowered, Causes(replayer), False).of_tag(tag, scan)
        if found is None:
            return Inquiry(engine, replayer, scan, subject.forced(scan), CrossReference(engine.lowered)).why(
                tag
            )
        links = [(said(each), each.site) for each in found.path]
    finally:
        adapter.look_at(scan).go(spot)
    for text, site in links[1:]:
        origin = Origin(site.file, site.line or 0) if site is not None and site.line else Origin()
        adapter.output(f"  <- {text}\n", more=places.source(origin))
    return links[0][0]
