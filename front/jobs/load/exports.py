"""An export opened as it is: a rack file for it in a temporary folder, as `scanrack l5x --rack` prints it."""

from __future__ import annotations

import atexit
import shutil
import tempfile
from pathlib import Path

from ...io_images.text_limits import TextLimitError
from ...ladder.model.errors import LadderError
from .program import EXPORT_SUFFIXES, SLC_SUFFIXES, ProgramError


def rack_of_export(export: Path, *, slc: bool | None = None) -> Path:
    """Write a rack file for an export into a temporary folder, which stays as long as the process.

    Modules that are not simulated are memory, messages end after 20 ms, and refused parts do nothing.

    Args:
        slc: whether it is a text of RSLogix 500; None to tell by the suffix.

    Raises:
        ProgramError: the export can't be used.
    """
    holder = tempfile.TemporaryDirectory(prefix="scanrack-")
    atexit.register(holder.cleanup)
    folder = Path(holder.name)
    slc = export.suffix in SLC_SUFFIXES if slc is None else slc
    program = export.resolve()
    if export.suffix not in EXPORT_SUFFIXES:  # its suffix says how a program is read
        program = folder / f"{export.stem}{'.SLC' if slc else '.L5X'}"
        shutil.copyfile(export, program)
    try:
        text = _slc_text(program) if slc else _l5x_text(program)
    except (LadderError, TextLimitError) as error:
        raise ProgramError(str(error)) from error
    path = folder / f"{export.stem}.toml"
    path.write_text(text, encoding="utf-8")
    return path


def _l5x_text(program: Path) -> str:
    from ...rockwell.l5x import import_l5x  # lxml takes time to import, and most racks are no exports
    from ..imports.l5x_rack import rack_of

    return rack_of(import_l5x(program, trial=True), program, recorded=False)


def _slc_text(program: Path) -> str:
    from ...rockwell.slc import import_slc
    from ..imports.slc_rack import rack_of_slc

    return rack_of_slc(import_slc(program, trial=True), program)
