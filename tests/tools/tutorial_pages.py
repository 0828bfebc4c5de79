"""The tutorial, docs/tutorial, done as a reader does it: files, changes and commands, in one folder.

    python tests/tools/tutorial_pages.py            says which outputs differ from those on the pages
    python tests/tools/tutorial_pages.py --write    writes them

A block of `toml`, `python` or `rung` after a line that ends with the name of a file and a colon is that file.
A block `diff` after such a line is a change of it. A block `console` is commands with what they print; a line
`...` there stands for lines left out. A search with `scanrack fuzz` takes long: `--search` does it, too.
"""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import chdir
from dataclasses import dataclass
from pathlib import Path

from scanrack.commands import build
from typer.testing import CliRunner

ROOT = Path(__file__).parents[2]
PAGES = sorted((ROOT / "docs" / "tutorial").glob("[1-8]-*.md"))
BLOCK = re.compile(r"^```(toml|python|rung|diff|console)\n(.*?)^```", re.MULTILINE | re.DOTALL)
NAMED = re.compile(r"`([\w./-]+)`[^`\n]*:\n\n\Z")
COMMAND = re.compile(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", re.MULTILINE)
DIFFERS = (
    (r"\([\d,]+ per second\)", "(N per second)"),
    (r"run in [\d.e-]+ s", "run in N s"),
    (r"in \d+\.\d+s", "in Ns"),
    (r"\([\d,]+ bytes\)", "(N bytes)"),
    (r" \[/\S+:\d+\]", ""),
)


@dataclass(frozen=True)
class Given:
    """A command of a page, what the page says it prints, and what it printed."""

    page: Path
    command: str
    said: str
    printed: str

    @property
    def same(self) -> bool:
        """Whether the page is right: rates and times of the machine, and lines left out, aside."""
        parts = [re.escape(_steady(part)) for part in re.split(r"^\.\.\.\n", self.said, flags=re.MULTILINE)]
        return re.fullmatch("(?s:.*)".join(parts), _steady(self.printed)) is not None


def _steady(text: str) -> str:
    for pattern, instead in DIFFERS:
        text = re.sub(pattern, instead, text)
    return text


def follow(folder: Path, search: bool = False) -> Iterator[Given]:
    """Do in the folder what the pages say; yield each command."""
    here = folder
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for block in BLOCK.finditer(text):
            name = NAMED.search(text[: block.start()])
            if block[1] == "console":
                for command, said in COMMAND.findall(block[2]):
                    if command.startswith(("cd ", "mkdir ")):
                        here = _moved(here, command)
                    elif search or "scanrack fuzz" not in command:
                        yield Given(page, command, said, _given(here, command))
            elif name is not None and block[1] == "diff":
                _change(here / name[1], block[2])
            elif name is not None:
                (here / name[1]).write_text(block[2], encoding="utf-8")


def _moved(here: Path, command: str) -> Path:
    """Where `cd`, perhaps after `mkdir`, leads."""
    there = (here / command.rpartition("cd ")[2]).resolve()
    if command.startswith("mkdir "):
        there.mkdir()
    return there


def _change(file: Path, diff: str) -> None:
    lines = diff.splitlines(keepends=True)
    old = "".join(line[1:] for line in lines if line[0] in " -")
    new = "".join(line[1:] for line in lines if line[0] in " +")
    text = file.read_text(encoding="utf-8")
    if text.count(old) != 1:
        raise ValueError(f"{file.name} does not have once what the page changes:\n{old}")
    file.write_text(text.replace(old, new), encoding="utf-8")


def _given(folder: Path, command: str) -> str:
    """What the command prints; a busy machine trips no watchdog, and a page to watch ends by itself."""
    for rack in folder.rglob("*.toml"):
        text = rack.read_text(encoding="utf-8")
        if "watchdog_ms" not in text:
            rack.write_text("watchdog_ms = 0\n" + text, encoding="utf-8")
    if command.startswith("pytest"):
        words = [sys.executable, "-m", *command.split(), "-p", "no:cacheprovider"]
        done = subprocess.run(
            words, cwd=folder, capture_output=True, text=True, check=False, encoding="utf-8"
        )
        return done.stdout + done.stderr
    words = shlex.split(command)[1:]
    watched = [each for each in words if each not in ("--open", "--paused")]
    watched += ["--scans", "50", "--time-scale", "max"]
    with chdir(folder):
        shown = CliRunner().invoke(build(), watched if words[0] == "watch" else words)
    return "" if words[0] == "watch" and shown.exit_code == 0 else shown.output


def main() -> None:
    """Say which outputs differ; with `--write` put what is printed in the place of what is said."""
    with tempfile.TemporaryDirectory() as folder:
        wrong = [each for each in follow(Path(folder), search="--search" in sys.argv) if not each.same]
    for each in wrong:
        sys.stdout.write(f"{each.page.name}: $ {each.command}\n{each.printed}\n")
        if "--write" in sys.argv:
            text = each.page.read_text(encoding="utf-8")
            before, after = (f"$ {each.command}\n{output}" for output in (each.said, each.printed))
            each.page.write_text(text.replace(before, after), encoding="utf-8")


if __name__ == "__main__":
    main()
