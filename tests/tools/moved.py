"""Move a module or a package, and rewrite every import of it: `python -m tests.tools.moved OLD NEW`.

    python -m tests.tools.moved scanrack.ladder.debug scanrack.ladder.debugging

Relative imports of the product, the dotted name in tests, docs and contracts, and paths from the root are
rewritten; the files are moved by git. A package that is new needs a line in `packages` of `pyproject.toml`.
"""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
ROOMS = ("scanrack", "io_images", "ladder", "rockwell", "runtime", "traces")
FRONT = "scanrack"
"""The room of the package `scanrack` itself: scanrack/jobs is scanrack.jobs."""


class Edit(NamedTuple):
    """A part of a line and its replacement."""

    line: int
    begin: int
    end: int
    text: str


def module_of(path: Path) -> str:
    """Return the dotted name of a file of the product.

    >>> module_of(Path("scanrack/jobs/run/running.py")), module_of(Path("ladder/__init__.py"))
    ('scanrack.jobs.run.running', 'scanrack.ladder')
    """
    parts = path.with_suffix("").parts
    parts = parts[1:] if parts[0] == FRONT else parts
    return ".".join(["scanrack", *(part for part in parts if part != "__init__")])


def path_of(module: str) -> Path:
    """Return the file or folder of a dotted name, from the root, without its suffix.

    >>> path_of("scanrack.ladder.debug").as_posix(), path_of("scanrack.jobs.why").as_posix()
    ('ladder/debug', 'scanrack/jobs/why')
    """
    parts = module.split(".")[1:]
    return Path(*parts) if parts[0] in ROOMS else Path(FRONT, *parts)


class Move:
    """A move of a module, or of a package with its modules."""

    def __init__(self, old: str, new: str) -> None:
        self.old, self.new = old, new
        self.is_package = (ROOT / path_of(old)).is_dir()

    def renamed(self, module: str) -> str:
        """Return the new name of a module, which may be its old one."""
        moves = module == self.old or module.startswith(f"{self.old}.")
        return self.new + module[len(self.old) :] if moves else module

    def edits(self, text: str, path: Path) -> Iterator[Edit]:
        """Yield the changes of the relative imports of a file of the product."""
        here = module_of(path)
        package = here if path.name == "__init__.py" else here.rpartition(".")[0]
        there = self.renamed(here)
        package_there = there if path.name == "__init__.py" else there.rpartition(".")[0]
        for node in ast.walk(ast.parse(text)):
            if not isinstance(node, ast.ImportFrom) or not node.level:
                continue
            base = package.split(".")[: len(package.split(".")) - node.level + 1]
            target = ".".join([*base, *filter(None, [node.module])])
            begin = node.col_offset + len("from ")
            end = begin + node.level + len(node.module or "")
            wanted = self.renamed(target)
            for name in node.names:
                if f"{target}.{name.name}" == self.old:
                    wanted, leaf = self.new.rpartition(".")[::2]
                    if len(node.names) > 1:
                        raise SystemExit(f"{path}:{node.lineno}: give {name.name} an import of its own")
                    as_old = "" if name.asname or leaf == name.name else f" as {name.asname or name.name}"
                    yield Edit(name.lineno, name.col_offset, name.col_offset + len(name.name), leaf + as_old)
            relative = wanted if leaves_room(wanted, package_there) else relative_to(wanted, package_there)
            if relative != "." * node.level + (node.module or ""):
                yield Edit(node.lineno, begin, end, relative)

    def rewritten(self, text: str, path: Path) -> str:
        """Return the text of a file with the new name."""
        if path.suffix == ".py" and path.parts[0] in ROOMS:
            lines = text.splitlines(keepends=True)
            for edit in sorted(self.edits(text, path), reverse=True):
                line = lines[edit.line - 1]
                lines[edit.line - 1] = line[: edit.begin] + edit.text + line[edit.end :]
            text = "".join(lines)
        parent, _, leaf = self.old.rpartition(".")
        new_parent, _, new_leaf = self.new.rpartition(".")
        text = re.sub(rf"\b{re.escape(self.old)}\b", self.new, text)
        text = re.sub(
            rf"^( *)from {re.escape(parent)} import {leaf}(?: as (\w+))?$",
            lambda found: f"{found[1]}from {new_parent} import {new_leaf} as {found[2] or leaf}",
            text,
            flags=re.MULTILINE,
        )
        old_path, new_path = (path_of(each).as_posix() for each in (self.old, self.new))
        tail = r"(?=/)" if self.is_package else r"(?=\.py\b)"
        return re.sub(rf"(?<![\w/.]){re.escape(old_path)}{tail}", new_path, text)

    def carry_out(self) -> list[str]:
        """Rewrite all files, and move the module; return the changed files."""
        listed = subprocess.run(
            ["git", "ls-files"], cwd=ROOT, check=True, capture_output=True, encoding="utf-8"
        )
        changed = []
        for name in listed.stdout.splitlines():
            file = ROOT / name
            if file.suffix not in (".py", ".md", ".toml", ".yml", ".txt", ".cfg", "") or not file.is_file():
                continue
            text = file.read_text(encoding="utf-8")
            if (new := self.rewritten(text, Path(name))) != text:
                file.write_text(new, encoding="utf-8", newline="\n")
                changed.append(name)
        suffix = "" if self.is_package else ".py"
        paths = [f"{path_of(each).as_posix()}{suffix}" for each in (self.old, self.new)]
        (ROOT / paths[1]).parent.mkdir(parents=True, exist_ok=True)
        subprocess.run(["git", "mv", *paths], cwd=ROOT, check=True)
        return changed


def leaves_room(module: str, package: str) -> bool:
    """Return whether a package imports a module from another room, which the import then names.

    >>> leaves_room("scanrack.ladder.run", "scanrack.jobs.why")
    True
    """
    return module.split(".")[1:2] != package.split(".")[1:2]


def relative_to(module: str, package: str) -> str:
    """Return a module as a relative import from a package.

    >>> relative_to("scanrack.ladder.run.engine", "scanrack.ladder.draw"), relative_to("a.b", "a.b")
    ('..run.engine', '.')
    """
    wanted, here = module.split("."), package.split(".")
    common = 0
    while common < min(len(wanted), len(here)) and wanted[common] == here[common]:
        common += 1
    return "." * (len(here) - common + 1) + ".".join(wanted[common:])


def main(old: str, new: str) -> None:
    """Move, and print the changed files, the tests among them counted."""
    changed = Move(old, new).carry_out()
    tests = sum(name.startswith("tests/") for name in changed)
    sys.stdout.write("\n".join([*changed, f"{len(changed)} files changed, {tests} of them tests", ""]))


if __name__ == "__main__":
    main(*sys.argv[1:3])
