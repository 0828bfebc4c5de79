"""The pages of docs/changes, one a release: the next one is made from changes/, a file for each change.

A file is called NAME.added.md, NAME.changed.md or NAME.fixed.md; its one line says what a user notices.
A line that was written into CHANGELOG.md becomes such a file.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "changes"
PAGES = ROOT / "docs/changes"
NEXT = PAGES / "unreleased.md"
CHANGELOG = ROOT / "CHANGELOG.md"
KINDS = {"added": "Added", "changed": "Changed", "fixed": "Fixed"}
BULLET = re.compile(r"^[-*] .*(?:\n  .*)*", re.MULTILINE)
FROM_CHANGES = re.compile(r"\]\(\.\./(docs/)?")
FROM_ROOT = re.compile(r"\]\((?!https?:|#)")
"""The beginnings of links that are written for a file in changes/, and for CHANGELOG.md."""


def changes() -> dict[Path, str]:
    """Return the line of each file, by its path."""
    return {file: file.read_text("utf-8").strip() for file in sorted(FOLDER.glob("*.md"))}


def kind_of(file: Path) -> str:
    """Return the kind of a change, which its file is called by."""
    return file.stem.rpartition(".")[2]


def page() -> str:
    """Return docs/changes/unreleased.md."""
    text = "# Unreleased\n"
    for kind, title in KINDS.items():
        lines = [
            FROM_CHANGES.sub(lambda link: "](../" if link[1] else "](../../", line)
            for file, line in changes().items()
            if kind_of(file) == kind
        ]
        text += f"\n## {title}\n\n" * bool(lines) + "".join(f"- {line}\n" for line in lines)
    return text


def changelog() -> str:
    """Return CHANGELOG.md."""
    headings = [file.read_text("utf-8").partition("\n")[0] for file in PAGES.glob("[0-9]*.md")]
    releases = sorted(
        (heading.removeprefix("# ").partition(" - ") for heading in headings),
        key=lambda release: [int(part) for part in release[0].split(".")],
        reverse=True,
    )
    rows = [
        f"* [{version}](docs/changes/{version}.md)" + f", {day}" * bool(day) for version, _, day in releases
    ]
    listed = "\n".join(["* [Unreleased](docs/changes/unreleased.md)", *rows])
    return f"# Changelog\n\nWhat a user notices, newest version first, a page for each:\n\n{listed}\n"


def written_by_hand() -> Iterator[tuple[Path, str]]:
    """Yield the file and the line of each change that is in CHANGELOG.md only."""
    known = set(changes().values())
    for old in PAGES.glob("[0-9]*.md"):
        known.update(
            _one_line(bullet).replace("](../", "](../docs/")
            for bullet in BULLET.findall(old.read_text("utf-8"))
        )
    files = set(changes())
    kind = "added"
    for part in re.split(r"^(?=###? )", CHANGELOG.read_text("utf-8"), flags=re.MULTILINE):
        heading = part.partition("\n")[0].strip("# ").lower()
        kind = heading if heading in KINDS else kind
        for bullet in BULLET.findall(part):
            line = FROM_ROOT.sub("](../", _one_line(bullet))
            if bullet not in changelog() and line not in known:
                known.add(line)
                yield _new_file(line, kind, files), line


def _one_line(bullet: str) -> str:
    return " ".join(bullet[2:].split())


def _new_file(line: str, kind: str, files: set[Path]) -> Path:
    """Return a path that is not among `files`, and add it: it begins with the first words of the line."""
    words = re.findall(r"[a-z0-9]+", re.sub(r"\]\(.*?\)|'s\b", "", line.lower()))
    name = "-".join([word for word in words if word not in ("a", "an", "the", "of", "scanrack")][:6])
    paths = (FOLDER / f"{name}{number}.{kind}.md" for number in ("", *(f"-{n}" for n in range(2, 100))))
    path = next(each for each in paths if each not in files)
    files.add(path)
    return path


def mistakes() -> Iterator[str]:
    """Yield what is wrong in the files of changes."""
    for file, line in changes().items():
        if kind_of(file) not in KINDS:
            yield f"{file.name}: must end with {', '.join(f'.{kind}.md' for kind in KINDS)}"
        if not line or "\n" in line or line.startswith(("- ", "* ", "#")):
            yield f"{file.name}: must be one line of text"
