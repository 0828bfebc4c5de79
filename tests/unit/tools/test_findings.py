"""The headers of findings/*.sh are complete and their tables current. The scripts themselves run by hand."""

from __future__ import annotations

import findings_page
import pytest

WHOLE = """\
#!/usr/bin/env bash
# What: a thing does b
# Packages:
#   pypi thing 1.2
#   npm @other/thing 3.4
# Date: 2026-11-29
# Meets: its users
# Expected: a
# Behavior:
#   It does b,
#   and c.
# Scanrack: nothing; see [the first page](index.md)
# Output:
#   b
. "$(dirname "$0")/lib.sh"
# What: no header
"""


def test_headers_are_complete() -> None:
    every = findings_page.findings()
    assert every
    assert list(findings_page.mistakes(every)) == []


def test_both_tables_are_current() -> None:
    page = findings_page.README.read_text(encoding="utf-8")
    assert page == findings_page.readme(page)
    assert findings_page.PAGE.read_text(encoding="utf-8") == findings_page.docs()


def test_a_header_is_read_up_to_the_first_command() -> None:
    found = findings_page.Finding("thing", findings_page.header(WHOLE))
    assert list(findings_page.mistakes([found])) == []
    assert found.packages == ["thing 1.2", "npm: @other/thing 3.4"]
    assert found.sentence("Behavior") == "It does b, and c."
    assert found.fields["What"] == "a thing does b"
    assert found.fields["Output"] == "b"


@pytest.mark.parametrize(
    ("old", "new", "mistake"),
    [
        ("# Expected: a\n", "", "thing: fields What, Packages, Date, Meets, Behavior"),
        ("# Expected: a\n", "# Expected:\n", "thing: Expected is empty"),
        ("pypi thing 1.2", "pypi thing", "thing: package 'pypi thing'"),
        ("pypi thing", "cargo thing", "thing: package 'cargo thing 1.2'"),
        ("2026-11-29", "29.11.2026", "thing: date '29.11.2026'"),
        ("[the first page](index.md)", "the first page", "thing: Scanrack has no link"),
        ("index.md", "nowhere.md", "thing: no page docs/nowhere.md"),
    ],
)
def test_a_mistake_in_a_header_is_named(old: str, new: str, mistake: str) -> None:
    found = findings_page.Finding("thing", findings_page.header(WHOLE.replace(old, new)))
    assert [each[: len(mistake)] for each in findings_page.mistakes([found])] == [mistake]
