"""Tag names in text form: `Recipe.Steps[2].Time`, `Program:Main.Step`, `N7:3`, `Flags.5`."""

from __future__ import annotations

import re
from dataclasses import replace

from scanrack.io_images.enip.codes import CipRefusedError
from scanrack.io_images.enip.listing import DWORD
from scanrack.io_images.enip.paths import PathStep, steps_of

from .database import Database, Target
from .nearest import nearest

_ELEMENT = re.compile(r"(?P<file>[A-Z]{1,2}\d*(?::\d+(?=[./]))?)[:.](?P<number>\d{1,5})", re.IGNORECASE)


def target_of(database: Database, text: str) -> Target:
    """Return the target of a name; the target of an array is all of its elements.

    Raises:
        ValueError: the tag, member or element does not exist.
    """
    steps = _steps(database, text)
    try:
        if steps and isinstance(steps[-1], int) and database.resolve(steps[:-1]).kind == DWORD:
            steps[-1:] = [steps[-1] // 32, str(steps[-1] % 32)]  # an element of an array of BOOLs
        target = database.resolve(steps)
    except CipRefusedError as error:
        raise ValueError(f"no tag {text!r}{nearest(database, text)}") from error
    return replace(target, count=1) if isinstance(steps[-1], int) else target


def _steps(database: Database, text: str) -> list[PathStep]:
    r"""Return the steps of a path.

    An element of a data file is a number after the file, and a bit is a number after `/`: `N7:3`, `I:1.0/14`.
    """
    if database.listing.files and (element := _ELEMENT.match(text)) is not None:
        path_text = text[element.end() :].lstrip("./")
        return [element["file"], int(element["number"]), *steps_of(path_text)]
    return steps_of(text)
