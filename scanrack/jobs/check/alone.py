"""A ladder program without a rack."""

from __future__ import annotations

from pathlib import Path

from scanrack.ladder.files.suffixes import STRUCTURED_SUFFIX, SUFFIX
from scanrack.runtime.config.rackspec import RackSpec

from ..load.loading import LoadedRack, is_export, load_job
from ..load.program import load_program


def load_any(file: str) -> tuple[LoadedRack, bool]:
    """Load a rack with its program, or only a ladder program; raise ValueError if the file is unusable.

    Returns:
        the loaded rack, and whether the program has no rack file. An export supplies its own slots and stubs.
    """
    path = Path(file)
    if path.suffix not in (SUFFIX, STRUCTURED_SUFFIX):
        return load_job(file), is_export(file)
    loaded = load_program(file)
    spec = RackSpec.model_construct(program=file, slot=())
    return LoadedRack(spec, loaded.function, path.name, path, path, path.name, notices=loaded.notices), True
