"""Makes a rack file for an export, in a temporary folder."""

from __future__ import annotations

import atexit
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scanrack.io_images.text_limits import TextLimitError
from scanrack.ladder.model.errors import LadderError

from ..imports.export_start import DOWNLOADED, ExportStart
from .program import EXPORT_SUFFIXES, SLC_SUFFIXES, ProgramError

if TYPE_CHECKING:
    from scanrack.rockwell.l5x import L5xImport
    from scanrack.rockwell.slc import SlcImport


def rack_of_export(
    program: Path, imported: L5xImport | SlcImport | None = None, export: ExportStart = DOWNLOADED
) -> Path:
    """Write the rack file that `scanrack l5x --print-rack` prints; return its path.

    Its temporary folder lasts as long as the process. Modules that are not simulated are only memory,
    messages end after 20 ms, and refused parts do nothing.

    Args:
        imported: the export, already imported for a trial; None = import it by its suffix.
        export: initial state of the program.

    Raises:
        ProgramError: the export can't be used.
    """
    import shutil  # most racks are not exports
    import tempfile

    from scanrack.rockwell.slc import SlcImport

    holder = tempfile.TemporaryDirectory(prefix="scanrack-")
    atexit.register(holder.cleanup)
    folder = Path(holder.name)
    is_slc = program.suffix in SLC_SUFFIXES if imported is None else isinstance(imported, SlcImport)
    source = program.resolve()
    if program.suffix not in EXPORT_SUFFIXES:  # the suffix determines how a program is read
        source = folder / f"{program.stem}{'.SLC' if is_slc else '.L5X'}"
        shutil.copyfile(program, source)
    try:
        text = _slc_text(source, imported) if is_slc else _l5x_text(source, imported, export)
    except (LadderError, TextLimitError) as error:
        raise ProgramError(str(error)) from error
    path = folder / f"{program.stem}.toml"
    path.write_text(text, encoding="utf-8", newline="\n")
    return path


def _l5x_text(program: Path, imported: Any, export: ExportStart) -> str:
    """Return the text of the rack file for an L5X; raise ProgramError if it contains no program."""
    from scanrack.rockwell.l5x import import_l5x  # lxml takes time to import

    from ..imports.l5x_rack import rack_of

    result = imported or import_l5x(program, trial=True, memory_mib=export.memory_mib)
    if not result.parts.programs:  # only an add-on instruction or data type was exported
        raise ProgramError(f"{program} contains no program")
    return rack_of(result, program, recorded=False, export=export)


def _slc_text(program: Path, imported: Any) -> str:
    """Return the text of the rack file for an SLC export."""
    from scanrack.rockwell.slc import import_slc

    from ..imports.slc_rack import rack_of_slc

    return rack_of_slc(imported or import_slc(program, trial=True), program)


def start_of_export(*, keep_values: bool, memory: int | None) -> ExportStart | None:
    """Return the initial state of an export from a command's options; None if none of them is given."""
    if not keep_values and memory is None:
        return None
    return ExportStart(
        keep_values=keep_values, memory_mib=DOWNLOADED.memory_mib if memory is None else memory
    )
