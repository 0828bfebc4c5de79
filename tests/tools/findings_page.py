"""The table in findings/README.md and the page docs/findings.md, from findings/*.sh.

The comment at the beginning of a script has lines `# field: text`, continued in lines that begin with `#   `.
What its line `install` pins are its packages. findings/README.md has the fields.
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
FIELDS = ("what", "date", "meets", "expected", "behavior", "product", "output")
PIN = re.compile(r"(?P<name>@?[\w./-]+)(?P<sign>==|=|@)(?P<version>\d[\w.+-]*)")
SOURCES = {"==": "", "@": "npm: ", "=": "Debian: "}
REQUIRED = {
    "folder=$(mktemp -d)": "it makes no temporary folder",
    "install ": "it installs no package",
    "observe ": "it observes nothing",
}
LINK = re.compile(r"\]\(([a-z0-9/-]+\.md)(?:#[a-z0-9-]+)?\)")

HEAD = """\
# Findings

This page lists behavior of other libraries, tools and formats that surprises even experts. Each row was run
on valid input without scanrack. Its script in `findings/` installs the named versions, runs them and fails if
the behavior has changed. `findings/run NAME` runs one script. The last column says what scanrack does.
"""


class Finding(NamedTuple):
    """A script: its header's fields without comment signs, and the packages that it installs."""

    name: str
    fields: dict[str, str]
    pins: list[str]
    text: str

    @property
    def packages(self) -> list[str]:
        """Return names and versions, with the registry where it is not PyPI."""
        found = [PIN.fullmatch(pin) for pin in self.pins]
        return [f"{SOURCES[pin['sign']]}{pin['name']} {pin['version']}" for pin in found if pin]

    def sentence(self, field: str) -> str:
        """Return a field as one line."""
        return " ".join(self.fields[field].split())


def findings() -> list[Finding]:
    """Return all findings, by name."""
    return [finding(file.stem, file.read_text("utf-8")) for file in sorted(FOLDER.glob("*.sh"))]


def finding(name: str, script: str) -> Finding:
    """Return a script's finding."""
    fields: dict[str, str] = {}
    field = ""
    for line in script.splitlines()[1:]:
        if not line.startswith("#"):
            break
        if found := re.match(r"# ([a-z]+):(?: (.*))?$", line):
            field = found[1]
            fields[field] = found[2] or ""
        elif field:
            fields[field] = f"{fields[field]}\n{line[4:]}".removeprefix("\n")
    pins = re.findall(r"^install (.*)$", script, re.MULTILINE)
    return Finding(name, fields, " ".join(pins).split(), script)


def mistakes(every: list[Finding]) -> Iterator[str]:
    """Yield what is wrong in scripts."""
    for name, fields, pins, text in every:
        if tuple(fields) != FIELDS:
            yield f"{name}: fields {', '.join(fields)}; must be {', '.join(FIELDS)}"
            continue
        yield from (f"{name}: {field} is empty" for field, value in fields.items() if not value.strip())
        yield from (f"{name}: {mistake}" for line, mistake in REQUIRED.items() if f"\n{line}" not in text)
        yield from (
            f"{name}: package {pin!r}: must be NAME==VERSION, NAME@VERSION (npm) or NAME=VERSION (Debian)"
            for pin in pins
            if not PIN.fullmatch(pin)
        )
        if "scanrack" in text:
            yield f"{name}: it names scanrack: a finding is about other software and runs without it"
        if not re.fullmatch(r"\d{4}-\d\d-\d\d", fields["date"]) or not date.fromisoformat(fields["date"]):
            yield f"{name}: date {fields['date']!r}: must be YYYY-MM-DD"
        links = LINK.findall(fields["product"])
        if not links:
            yield f"{name}: product has no link to a page of docs/"
        yield from (f"{name}: no page docs/{link}" for link in links if not (PAGE.parent / link).is_file())


def readme(page: str) -> str:
    """Return findings/README.md with all findings."""
    rows = "".join(
        f"| [{each.name}]({each.name}.sh) | {', '.join(each.packages)} | {each.fields['date']} "
        f"| {each.fields['what']} |\n"
        for each in findings()
    )
    head = r"(^\| name \| packages, versions \| date \| what \|\n\|[-|]+\n)(?:\|.*\n)*"
    page, tables = re.subn(head, lambda found: found[1] + rows, page, flags=re.MULTILINE)
    assert tables == 1, "findings/README.md has no table of findings"
    return page


def docs() -> str:
    """Return docs/findings.md."""
    rows = "".join(
        f"| [{each.fields['what']}](../findings/{each.name}.sh) "
        f"| {', '.join(each.packages)}; {each.fields['date']} "
        f"| {each.sentence('meets')} | {each.sentence('product')} |\n"
        for each in findings()
    )
    return f"{HEAD}\n| finding | versions, date | who meets it | scanrack |\n|---|---|---|---|\n{rows}"
