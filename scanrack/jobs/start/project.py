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
    ("scanrack tags {rack}", "list the tags that an HMI sees; --help explains how to serve them"),
    ("pip install pytest && pytest", "run the project's tests"),
    ("scanrack editor schema --write", "have an editor complete and check rack files"),
    ("scanrack doctor", "list missing parts of this installation, and how to install them"),
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
    _check_empty(folder)
    folder.mkdir(parents=True, exist_ok=True)
    racks = _racks(source)
    copies = [_copied(file, folder, racks) for file in _source_files(source, racks)]
    next_steps = folder / FILE_OF_NEXT
    with next_steps.open("x", encoding="utf-8", newline="\n") as file:
        file.write(_next_steps(racks[0]))
    return [*copies, next_steps]


def _next_steps(rack: str) -> str:
    """Return the text of NEXT.md.

    >>> _next_steps("line.toml").splitlines()[3]
    '    scanrack run line.toml           run it as fast as it can, and record every scan'
    """
    commands = [(command.format(rack=rack), purpose) for command, purpose in NEXT]
    width = max(len(command) for command, _ in commands)
    steps = "\n".join(f"    {command:{width}}  {purpose}" for command, purpose in commands)
    hint = "Edit the program while `scanrack watch` shows it: a saved file is used from the next scan."
    return f"# Next\n\n{steps}\n\n{hint}\n"


def _examples() -> Traversable:
    return files(f"{__package__.split('.')[0]}.examples")


def _example(name: str) -> Traversable:
    examples = example_names()
    if name not in examples:
        raise ProjectError(f"no example {name!r}; choose from {', '.join(examples)}")
    return _examples() / name


def _check_empty(folder: Path) -> None:
    """Raise a ProjectError unless a folder is empty or does not exist."""
    if not folder.exists():
        return
    if not folder.is_dir():
        raise ProjectError(f"{folder} is a file: choose a new or empty folder")
    existing = sorted(path.name for path in folder.iterdir())
    if existing:
        shown = ", ".join(existing[:3]) + (", ..." if len(existing) > 3 else "")
        raise ProjectError(f"{folder} is not empty ({shown}): choose a new or empty folder")


def _racks(source: Traversable) -> list[str]:
    return sorted(path.name for path in source.iterdir() if path.name.endswith(".toml"))


def _source_files(source: Traversable, racks: list[str]) -> Iterator[Traversable]:
    """Yield the files of a folder to copy, rack files first."""
    yield from (source / name for name in racks)
    for path in sorted(source.iterdir(), key=lambda path: path.name):
        if path.is_file() and path.name not in racks and not path.name.endswith((EXPECTED, ".pyc")):
            yield path


def _copied(source: Traversable, folder: Path, racks: list[str]) -> Path:
    """Copy a file into a folder; a template's rack is named after the folder. Return the copy's path."""
    target = folder / source.name
    content = source.read_bytes()
    if source.name in racks:
        content = content.replace(b'"NAME"', f'"{_toml_name(folder)}"'.encode())
    with target.open("xb") as file:
        file.write(content)
    return target


def _toml_name(folder: Path) -> str:
    """Return a folder's name without characters that have a special meaning in TOML."""
    return "".join(letter for letter in folder.resolve().name if letter.isprintable() and letter not in '"\\')
