"""Creates a project folder with a rack, a program that homes and moves, its test, and the next steps."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path

LOGICS = ("python", "ladder", "steps")
"""Languages of a new program; each is a folder of `templates`."""

EXPECTED = ".txt"
"""Suffix of an example's expected output, which only scanrack's own checks read."""

NEXT = (
    ("scanrack watch {rack} --open", "see it run in the browser"),
    ("scanrack run {rack}", "run it as fast as it can, and record every scan"),
    ("scanrack check {rack}", "look for mistakes without a run"),
    ("scanrack tags {rack}", "list the tags that an HMI sees; --help says how to serve them"),
    ("pip install pytest && pytest", "run the tests beside it, if there are some"),
    ("scanrack editor schema --write", "have an editor complete and check rack files"),
    ("scanrack doctor", "what this installation lacks, and how to fix it"),
    ("scanrack fuzz {rack}", "search for inputs and faults that break the program"),
)
"""The next steps for a new project: commands and their purposes."""

FILE_OF_NEXT = "NEXT.md"


class ProjectError(ValueError):
    """The folder can't be used, or the example does not exist."""


def example_names() -> list[str]:
    """Return the names of the examples that come with the package, in order."""
    return sorted(folder.name for folder in _examples().iterdir() if folder.is_dir() and _racks(folder))


def new_project(folder: Path, logic: str = "python", example: str | None = None) -> list[Path]:
    """Write a project into a new or empty folder; return its files, rack file first.

    Args:
        logic: language of the program, one of `LOGICS`.
        example: name from `example_names()` of an example to copy instead.

    Raises:
        ProjectError: the folder is not empty, or the example does not exist.
        OSError: a file can't be written.
    """
    source = _example(example) if example is not None else files(__package__) / "templates" / logic
    _refuse_what_is_there(folder)
    folder.mkdir(parents=True, exist_ok=True)
    racks = _racks(source)
    written = [_written(folder, name, racks) for name in _in_order(source, racks)]
    note = folder / FILE_OF_NEXT
    with note.open("x", encoding="utf-8", newline="\n") as file:
        file.write(_next_steps(str(racks[0])))
    return [*written, note]


def _next_steps(rack: str) -> str:
    """Return the text of NEXT.md.

    >>> _next_steps("line.toml").splitlines()[3]
    '    scanrack run line.toml           run it as fast as it can, and record every scan'
    """
    commands = [(command.format(rack=rack), use) for command, use in NEXT]
    width = max(len(command) for command, _ in commands)
    steps = "\n".join(f"    {command:{width}}  {use}" for command, use in commands)
    saved = "Edit the program while `scanrack watch` shows it: a saved file is used from the next scan."
    return f"# Next\n\n{steps}\n\n{saved}\n"


def _examples() -> Traversable:
    return files(f"{__package__.split('.')[0]}.examples")


def _example(name: str) -> Traversable:
    if name not in (known := example_names()):
        raise ProjectError(f"no example {name!r}; choose from {', '.join(known)}")
    return _examples() / name


def _refuse_what_is_there(folder: Path) -> None:
    if folder.exists() and not folder.is_dir():
        raise ProjectError(f"{folder} is a file: a new project takes a new or empty folder")
    if existing := sorted(path.name for path in folder.iterdir()) if folder.is_dir() else []:
        shown = ", ".join(existing[:3]) + (", ..." if len(existing) > 3 else "")
        raise ProjectError(f"{folder} has {shown} in it: a new project takes a new or empty folder")


def _racks(source: Traversable) -> list[str]:
    return sorted(path.name for path in source.iterdir() if path.name.endswith(".toml"))


def _in_order(source: Traversable, racks: list[str]) -> Iterator[Traversable]:
    """Yield the files of a folder, rack files first."""
    others = (
        path
        for path in sorted(source.iterdir(), key=lambda each: each.name)
        if path.is_file() and path.name not in racks and not path.name.endswith((EXPECTED, ".pyc"))
    )
    yield from (source / name for name in racks)
    yield from others


def _written(folder: Path, source: Traversable, racks: list[str]) -> Path:
    """Copy a file; a template's rack is named after its folder."""
    target = folder / source.name
    text = source.read_bytes()
    if source.name in racks:
        text = text.replace(b'"NAME"', f'"{_plain(folder)}"'.encode())
    with target.open("xb") as file:
        file.write(text)
    return target


def _plain(folder: Path) -> str:
    """Return a folder's name without characters that have a special meaning in TOML."""
    return "".join(letter for letter in folder.resolve().name if letter.isprintable() and letter not in '"\\')
