"""The table in findings/README.md and the page docs/findings.md, from the headers of findings/*.sh.

A header is the comment at the beginning of a script: lines `# Field: text`, continued in lines that begin
with `#   `. findings/README.md has the fields.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from datetime import date
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "findings"
README = FOLDER / "README.md"
PAGE = ROOT / "docs/findings.md"
FIELDS = ("What", "Packages", "Date", "Meets", "Expected", "Behavior", "Scanrack", "Output")
SOURCES = {"pypi": "", "npm": "npm: ", "debian": "Debian: "}
LINK = re.compile(r"\]\(([a-z0-9/-]+\.md)(?:#[a-z0-9-]+)?\)")

HEAD = """\
# Findings

What libraries, tools and formats around scanrack do that an expert would not guess. Each row was run on valid
input without scanrack; its script in `findings/` installs the named versions, runs them and fails if the
behavior has changed. `findings/run NAME` runs one. Each row says what scanrack does about it.
"""


class Finding(NamedTuple):
    """A script's header: the text of each field, without comment signs."""

    name: str
    fields: dict[str, str]

    @property
    def packages(self) -> list[str]:
        """Return names and versions, with the registry where it is not PyPI."""
        rows = [line.split() for line in self.fields["Packages"].splitlines()]
        return [f"{SOURCES[source]}{name} {version}" for source, name, version in rows]

    def sentence(self, field: str) -> str:
        """Return a field as one line."""
        return " ".join(self.fields[field].split())


def findings() -> list[Finding]:
    """Return all findings, by name."""
    return [
        Finding(file.stem, header(file.read_text("utf-8")))
        for file in sorted(FOLDER.glob("*.sh"))
        if file.stem != "lib"
    ]


def header(script: str) -> dict[str, str]:
    """Return the fields of a script's header, in their order."""
    fields: dict[str, str] = {}
    name = ""
    for line in script.splitlines()[1:]:
        if not line.startswith("#"):
            break
        if found := re.match(r"# ([A-Z][a-z]+):(?: (.*))?$", line):
            name = found[1]
            fields[name] = found[2] or ""
        elif name:
            fields[name] = f"{fields[name]}\n{line[4:]}".removeprefix("\n")
    return fields


def mistakes(every: list[Finding]) -> Iterator[str]:
    """Yield what is wrong in headers."""
    for name, fields in every:
        if tuple(fields) != FIELDS:
            yield f"{name}: fields {', '.join(fields)}; must be {', '.join(FIELDS)}"
            continue
        yield from (f"{name}: {field} is empty" for field, text in fields.items() if not text.strip())
        for line in fields["Packages"].splitlines():
            if len(line.split()) != 3 or line.split()[0] not in SOURCES:
                yield f"{name}: package {line!r}: must be pypi, npm or debian, a name, a version"
        if not re.fullmatch(r"\d{4}-\d\d-\d\d", fields["Date"]) or not date.fromisoformat(fields["Date"]):
            yield f"{name}: date {fields['Date']!r}: must be YYYY-MM-DD"
        links = LINK.findall(fields["Scanrack"])
        if not links:
            yield f"{name}: Scanrack has no link to a page of docs/"
        yield from (f"{name}: no page docs/{link}" for link in links if not (PAGE.parent / link).is_file())


def readme(page: str) -> str:
    """Return findings/README.md with all findings."""
    rows = "".join(
        f"| [{each.name}]({each.name}.sh) | {', '.join(each.packages)} | {each.fields['Date']} "
        f"| {each.fields['What']} |\n"
        for each in findings()
    )
    head = r"(^\| name \| packages, versions \| date \| what \|\n\|[-|]+\n)(?:\|.*\n)*"
    page, tables = re.subn(head, lambda found: found[1] + rows, page, flags=re.MULTILINE)
    assert tables == 1, "findings/README.md has no table of findings"
    return page


def docs() -> str:
    """Return docs/findings.md."""
    rows = "".join(
        f"| [{each.fields['What']}](../findings/{each.name}.sh) "
        f"| {', '.join(each.packages)}; {each.fields['Date']} "
        f"| {each.sentence('Meets')} | {each.sentence('Scanrack')} |\n"
        for each in findings()
    )
    return f"{HEAD}\n| finding | versions, date | who meets it | scanrack |\n|---|---|---|---|\n{rows}"
