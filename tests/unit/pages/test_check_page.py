"""docs/check-rules.md has every rule of `scanrack check`."""

from check_page import PAGE, REMEDY, page
from scanrack.jobs.check import RULES


def test_the_page_is_as_it_should_be():
    assert PAGE.read_text(encoding="utf-8") == page(), REMEDY


def test_every_rule_has_a_section_with_an_example():
    text = PAGE.read_text(encoding="utf-8")
    for rule in RULES:
        section = text.split(f"\n## {rule.id}\n")[1].split("\n## ")[0]
        assert "    good: " in section, rule.id
        assert "    bad:  " in section, rule.id
