"""The routines and rungs of a program at the lines of its files.

feeder.rung:38   <->   Main, rung 6
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from importlib.resources import files
from pathlib import Path

from scanrack.ladder import LadderLogic
from scanrack.ladder.compiler.observed import LineKey
from scanrack.ladder.model.tree import Origin
from scanrack.ladder.python.line_marks import marked_lines
from typing_extensions import override

from .protocol import DebugError, Json


class Places:
    """The lines of a program.

    Args:
        folders: folders on this machine that may contain the files of a recording.

    Attributes:
        power: whether its lines have power, as rungs do.
    """

    power = True

    def __init__(self, folders: Iterable[Path] = ()) -> None:
        self._folders = tuple(folders)
        self._paths: dict[str, Path | None] = {}

    def keys(self) -> Iterator[tuple[Origin, LineKey]]:
        """Yield the rungs, statements or lines on which a breakpoint can be set."""
        raise NotImplementedError

    def named(self, text: str) -> list[LineKey] | None:
        """Return the rung with a name like `Main.3`, or the first rung of `Main`; None if not found."""
        raise NotImplementedError

    @cached_property
    def lines(self) -> Mapping[Path, Mapping[int, list[LineKey]]]:
        """The rungs and statements, by file and line."""
        lines: dict[Path, dict[int, list[LineKey]]] = {}
        for origin, key in self.keys():
            path = self.path(origin)
            if path is not None:
                keys = lines.setdefault(path, {}).setdefault(origin.line, [])
                if key not in keys:
                    keys.append(key)
        return lines

    def path(self, origin: Origin) -> Path | None:
        """Return the file of a rung on this machine, or None if this machine does not have it."""
        name = origin.file
        if name not in self._paths:
            self._paths[name] = self._find_file(name) if name and origin.line else None
        return self._paths[name]

    def _find_file(self, name: str) -> Path | None:
        """Find the program's file in the folders, at its path or as shipped; return None if all differ."""
        file_path = Path(name)
        shipped = Path(str(files("scanrack.ladder"))) / "blocks" / file_path.name  # of `USE axis3601`
        for file in (*(folder / file_path.name for folder in self._folders), file_path, shipped):
            if file.is_file() and _is_copy(file, file_path):
                return file.resolve()
        return None

    def first_line_from(self, path: str, line: int) -> tuple[int, list[LineKey]]:
        """Return the first line at or after `line` with an instruction, and its rungs.

        Raises:
            DebugError: the file is not part of the program, or has no instruction at or after the line.
        """
        resolved = Path(path).resolve()
        known_lines = self.lines.get(resolved) or self._adopted(resolved)
        if known_lines is None:
            names = ", ".join(sorted(known_file.name for known_file in self.lines))
            if resolved.name in {known_file.name for known_file in self.lines}:
                raise DebugError(f"{resolved.name} differs from the program that runs")
            raise DebugError(f"{Path(path).name} is not a file of the program, which has {names}")
        number = min((number for number in known_lines if number >= line), default=None)
        if number is None:
            raise DebugError(f"{Path(path).name}, line {line}: no instruction from this line to the end")
        return number, known_lines[number]

    def _adopted(self, path: Path) -> Mapping[int, list[LineKey]] | None:
        """Replace a recording's copy of a file by a client's file with the same bytes; return its lines."""
        for name, program_file in self._paths.items():
            if program_file is None or program_file.name != path.name or not path.is_file():
                continue
            if _is_copy(path, program_file):
                self._paths[name] = path
                self.__dict__.pop("lines", None)
                return self.lines.get(path)
        return None

    def of(self, key: LineKey) -> tuple[str, int]:
        """Return the file and line of a rung; "" and 0 if the file is not on this machine."""
        for path, lines in self.lines.items():
            for line, keys in lines.items():
                if key in keys:
                    return str(path), line
        return "", 0

    def source(self, origin: Origin) -> Json:
        """Return a rung's file and line as protocol fields; empty if the file is not on this machine."""
        path = self.path(origin)
        if path is None:
            return {}
        return {"source": {"name": path.name, "path": str(path)}, "line": origin.line, "column": 1}


class RungPlaces(Places):
    """The lines of a ladder program."""

    def __init__(self, program: LadderLogic, folders: Iterable[Path] = ()) -> None:
        super().__init__(folders)
        self._lowered = program.build()

    @override
    def keys(self) -> Iterator[tuple[Origin, LineKey]]:
        for name, routine in self._lowered.routines.items():
            yield from ((line.origin, (name, line.number)) for line in routine.lines if line.number >= 0)

    @override
    def named(self, text: str) -> list[LineKey] | None:
        routine_name, dot, number = text.rpartition(".")
        is_numbered = bool(dot) and number.isdigit()
        name = (routine_name if is_numbered else text).upper()
        # `Main` also finds `\Feeder.Main`, unless there are several
        matches = [
            routine for routine in self._lowered.routines if name in (routine, routine.rpartition(".")[2])
        ]
        if len(matches) != 1:
            return None
        numbers = [line.number for line in self._lowered.routines[matches[0]].lines if line.number >= 0]
        rung = int(number) if is_numbered else min(numbers, default=-1)
        return [(matches[0], rung)] if rung in numbers else None


class TextPlaces(Places):
    """The lines of a Python program or of a list of steps.

    Args:
        files: the files of the program and of the modules beside it.
        steps: the lines of a list of steps; empty for Python.
    """

    power = False

    def __init__(self, files: Sequence[Path], steps: Sequence[int], folders: Iterable[Path] = ()) -> None:
        super().__init__(folders)
        self._files, self._steps = files, steps

    @override
    def keys(self) -> Iterator[tuple[Origin, LineKey]]:
        for file in self._files:
            for line in self._steps or marked_lines(file.read_bytes()):
                yield Origin(str(file), line), (file.name, line)

    @override
    def path(self, origin: Origin) -> Path | None:
        program_file = next((file for file in self._files if file.name == Path(origin.file).name), None)
        return None if program_file is None else super().path(Origin(str(program_file), origin.line))

    @override
    def named(self, text: str) -> list[LineKey] | None:
        name, _, line = text.rpartition(".")
        keys = {key for _origin, key in self.keys()}
        return [(name, int(line))] if line.isdigit() and (name, int(line)) in keys else None


def _is_copy(path: Path, original: Path) -> bool:
    """Return whether a file is the original, or has the same bytes."""
    if not original.is_file():
        return True  # a recording does not have the full path of an imported file
    return path.samefile(original) or path.read_bytes() == original.read_bytes()
