"""Lets executed Python files import modules from their own folders.

    importer                                     finds
    a program, a rack file, a stub, invariants   installed modules, then those in its own folder
    a module from such a folder                  installed modules, then those in the same folder
    Python, scanrack, the libraries              installed modules

Therefore, a `json.py` beside a program never replaces Python's own module. The folder is stored in the spec
of the importing module; `sys.path` stays unchanged.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from contextvars import ContextVar
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from pathlib import Path
from types import CodeType, FrameType, ModuleType
from typing import Any

Compiler = Callable[[bytes, str], CodeType]

BESIDE: ContextVar[Compiler | None] = ContextVar("BESIDE", default=None)
"""Compiles the modules that are found beside programs; None = compile as Python does."""


class _Folder(str):
    """The folder of an executed file, stored as `loader_state` of its spec."""

    __slots__ = ()


class _Finder(MetaPathFinder):
    """Searches the folder of the importing module for modules."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return the spec of a top-level module in the folder of the importing module, or None."""
        folder = None if path is not None else _folder_of(_importer(sys._getframe(1)))
        if folder is None:
            return None
        spec = PathFinder.find_spec(fullname, [folder])
        if spec is None:
            return None
        return _beside(spec, folder)


class _FirstFinder(MetaPathFinder):
    """Finds modules beside programs before Python's own finders do, so that `BESIDE` compiles them.

    It comes first in `sys.meta_path`: a module that Python itself finds never reaches `_Finder`, the last.
    """

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return the spec of a module that Python finds in the folder of the importing module.

        Return None for any other module, and while `BESIDE` is not set.
        """
        folder = None if BESIDE.get() is None else _folder_of(_importer(sys._getframe(1)))
        if folder is None:
            return None
        spec = PathFinder.find_spec(fullname, path)
        if spec is None or not Path(spec.origin or "").resolve().is_relative_to(folder):
            return None
        return _beside(spec, folder)


class _Loader(SourceFileLoader):
    """Loads a module that `BESIDE` compiles; its code is not cached in a file."""

    compiler: Compiler

    def get_code(self, fullname: str) -> CodeType:
        """See `SourceFileLoader`."""
        path = self.get_filename(fullname)
        return self.compiler(self.get_data(path), path)


def _beside(spec: ModuleSpec, folder: _Folder) -> ModuleSpec:
    """Return the spec of a module in the importer's folder; `BESIDE` compiles it, if set."""
    spec.loader_state = folder
    compiler = BESIDE.get()
    if compiler is not None and isinstance(spec.loader, SourceFileLoader):
        spec.loader = _Loader(spec.name, spec.loader.path)
        spec.loader.compiler = compiler
    return spec


_FINDER = _Finder()
_FIRST = _FirstFinder()


def find_beside(path: Path, spec: ModuleSpec) -> ModuleSpec:
    """Return a spec for `module.__spec__` that lets an executed file find the modules beside it."""
    if _FINDER not in sys.meta_path:
        sys.meta_path.append(_FINDER)
    if BESIDE.get() is not None and _FIRST not in sys.meta_path:
        sys.meta_path.insert(0, _FIRST)
    spec.loader_state = _Folder(path.parent.resolve())
    return spec


def shadowed(path: Path, error: BaseException) -> str:
    """Return a hint if an import failed because an installed module hides a module beside a file."""
    owner = error.obj if isinstance(error, AttributeError) else None
    name = error.name if isinstance(error, ImportError) else getattr(owner, "__name__", None)
    module = sys.modules.get(name or "")
    if module is None or _folder_of(vars(module)) is not None:
        return ""
    beside = path.parent / f"{name}.py"
    return f"; {beside} is not imported: an installed module has its name" if beside.is_file() else ""


def _importer(frame: FrameType | None) -> Mapping[str, Any]:
    """Return the globals of the importing code, which is above the import system's own frames."""
    while frame is not None:
        name = frame.f_globals.get("__name__")
        if name is not None and name.partition(".")[0] != "importlib":
            return frame.f_globals
        frame = frame.f_back
    return {}


def _folder_of(module: Mapping[str, Any]) -> _Folder | None:
    """Return the folder where a module finds other modules; a module in a package uses the package's."""
    spec = module.get("__spec__")
    package, dot, _rest = getattr(spec, "name", "").partition(".")
    if dot:
        spec = getattr(sys.modules.get(package), "__spec__", None)
    folder = getattr(spec, "loader_state", None)
    return folder if isinstance(folder, _Folder) else None
