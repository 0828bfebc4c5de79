"""The scripts findings/*.sh are complete and their tables current. The scripts themselves run by hand."""

from __future__ import annotations

import os

import findings_page
import pytest

WHOLE = """\
#!/usr/bin/env bash
# what: a thing does b
# date: 2026-11-29
# meets: its users
# expected: a
# behavior:
#   It does b,
#   and c.
# product: nothing; see [the first page](index.md)
# output:
#   b
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install thing==1.2 @other/thing@3.4 libthing5=3.1.6-2.1+deb12u1
observe python -c "print('b')"
# what: no header
"""


def test_scripts_are_complete() -> None:
    every = findings_page.findings()
    assert every
    assert list(findings_page.mistakes(every)) == []


def test_both_tables_are_current() -> None:
    page = findings_page.README.read_text(encoding="utf-8")
    assert page == findings_page.readme(page)
    assert findings_page.PAGE.read_text(encoding="utf-8") == findings_page.docs()


def test_a_script_runs_by_its_name() -> None:
    scripts = [*findings_page.FOLDER.glob("*.sh"), findings_page.FOLDER / "run"]
    assert [each.name for each in scripts if not os.access(each, os.X_OK)] == []


def test_a_header_is_read_up_to_the_first_command() -> None:
    found = findings_page.finding("thing", WHOLE)
    assert list(findings_page.mistakes([found])) == []
    assert found.packages == ["thing 1.2", "npm: @other/thing 3.4", "Debian: libthing5 3.1.6-2.1+deb12u1"]
    assert found.sentence("behavior") == "It does b, and c."
    assert found.fields["what"] == "a thing does b"
    assert found.fields["output"] == "b"


@pytest.mark.parametrize(
    ("old", "new", "mistake"),
    [
        ("# expected: a\n", "", "thing: fields what, date, meets, behavior"),
        ("# expected: a\n", "# expected:\n", "thing: expected is empty"),
        ("thing==1.2", "thing", "thing: package 'thing'"),
        ("thing==1.2", "thing>=1.2", "thing: package 'thing>=1.2'"),
        ("install ", "echo ", "thing: it installs no package"),
        ("observe ", "", "thing: it observes nothing"),
        ("folder=$(mktemp -d)", "folder=/tmp/thing", "thing: it makes no temporary folder"),
        ("print('b')", "import scanrack", "thing: it names scanrack"),
        ("2026-11-29", "29.11.2026", "thing: date '29.11.2026'"),
        ("[the first page](index.md)", "the first page", "thing: product has no link"),
        ("index.md", "nowhere.md", "thing: no page docs/nowhere.md"),
    ],
)
def test_a_mistake_in_a_script_is_named(old: str, new: str, mistake: str) -> None:
    found = findings_page.finding("thing", WHOLE.replace(old, new))
    assert [each[: len(mistake)] for each in findings_page.mistakes([found])] == [mistake]
