"""Write what is generated: pages, tables, the editors' schema, and of which programs the pictures are.

    python -m tests.tools.generate                 write it all; a minute, most of it for the rules
    python -m tests.tools.generate cards commands  only these
    python -m tests.tools.generate --check         say what is not current, with exit status 1

Not here is what takes a decision or a program of others: recordings (golden.py, example_digests.py), what the
tutorial prints (tutorial_pages.py), the pictures themselves.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Sequence
from difflib import ndiff
from pathlib import Path
from typing import NamedTuple

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

import answers_page
import cards_page
import changes_page
import check_page
import clients_tried
import commands_page
import debugger_page
import differences_page
import drives_page
import findings_page
import formats_page
import install_lines
import instructions_page
import picture_sources
import rack_page
import rule_proofs
from scanrack.runtime.config.rack_schema import rack_schema

ROOT = Path(__file__).parents[2]
REMEDY = "python -m tests.tools.generate"


class Generated(NamedTuple):
    """A file as it should be, and what is wrong that writing it does not fix."""

    path: Path
    text: str
    wrong: Sequence[str] = ()


def _table(page: Path, written: Callable[[str], str]) -> Iterator[Generated]:
    yield Generated(page, written(page.read_text(encoding="utf-8")))


def _rules() -> Iterator[Generated]:
    found = rule_proofs.collect()
    yield Generated(rule_proofs.PAGE, rule_proofs.page_of(found), list(rule_proofs.mistakes(found)))


def _schema() -> Iterator[Generated]:
    text = json.dumps(rack_schema(draft4=True), indent=1, ensure_ascii=False)
    yield Generated(ROOT / "editors/vscode/rack.schema.json", f"{text}\n")


def _pictures() -> Iterator[Generated]:
    """Name the pictures to draw again: their programs have changed."""
    yield Generated(picture_sources.DIGESTS, picture_sources.text(), list(picture_sources.outdated()))


def _install() -> Iterator[Generated]:
    for page in install_lines.pages():
        yield from _table(page, install_lines.installed_as_today)


def _differences() -> Iterator[Generated]:
    yield Generated(differences_page.PAGE, differences_page.page())


def _findings() -> Iterator[Generated]:
    wrong = list(findings_page.mistakes(findings_page.findings()))
    yield Generated(findings_page.PAGE, findings_page.docs(), wrong)
    yield from _table(findings_page.README, findings_page.readme)


def _changes() -> Iterator[Generated]:
    for file, line in list(changes_page.written_by_hand()):
        yield Generated(file, f"{line}\n")
    yield Generated(changes_page.NEXT, changes_page.page(), list(changes_page.mistakes()))
    yield Generated(changes_page.CHANGELOG, changes_page.changelog())


GENERATORS: dict[str, Callable[[], Iterator[Generated]]] = {
    "answers": lambda: _table(answers_page.PAGE, answers_page.written),
    "cards": lambda: _table(cards_page.PAGE, cards_page.written),
    "changes": _changes,
    "check": lambda: iter([Generated(check_page.PAGE, check_page.page())]),
    "clients": lambda: _table(clients_tried.PAGE, clients_tried.written),
    "commands": lambda: iter([Generated(commands_page.PAGE, commands_page.page())]),
    "debugger": lambda: _table(debugger_page.PAGE, debugger_page.written),
    "differences": _differences,
    "drives": lambda: iter([Generated(drives_page.PAGE, drives_page.page())]),
    "findings": _findings,
    "formats": lambda: _table(formats_page.PAGE, formats_page.written),
    "install": _install,
    "instructions": lambda: _table(instructions_page.PAGE, instructions_page.written),
    "pictures": _pictures,
    "rack": lambda: iter([Generated(rack_page.PAGE, rack_page.page())]),
    "rules": _rules,
    "schema": _schema,
}
"""What is generated, by the word that chooses it."""


def stale(each: Generated) -> list[str]:
    """Return the lines in which a file is not current: - are those of the file."""
    there = each.path.read_text(encoding="utf-8") if each.path.exists() else ""
    if there == each.text:
        return []
    return [line for line in ndiff(there.splitlines(), each.text.splitlines()) if line[0] in "+-"] or [
        "its end"
    ]


def main(words: Sequence[str]) -> int:
    """Write or check; return 1 if something is wrong or not current, 2 for an unknown word."""
    check = "--check" in words
    names = [word for word in words if word != "--check"]
    unknown = [name for name in names if name not in GENERATORS]
    if unknown:
        sys.stderr.write(f"{unknown[0]} is not generated: {', '.join(GENERATORS)}\n")
        return 2
    status = 0
    for name in names or GENERATORS:
        for each in GENERATORS[name]():
            lines = stale(each)
            sys.stderr.writelines(f"{line}\n" for line in each.wrong)
            if lines and check:
                sys.stderr.write(f"{each.path.relative_to(ROOT)}: {REMEDY} {name}\n")
                sys.stderr.writelines(f"  {line}\n" for line in lines[:10])
            elif lines:
                sys.stdout.write(f"{each.path.relative_to(ROOT)}\n")
                each.path.write_text(each.text, encoding="utf-8", newline="\n")
            status |= bool(each.wrong) or (check and bool(lines))
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
