"""Integers that no double has are on the page as they are, and are written as they were typed."""

from pathlib import Path

from watched_page import watching

PROGRAM = """PROGRAM wide
TAG Total : LINT := 9007199254740993
TAG Most : ULINT := 18446744073709551615
ROUTINE Main
ADD(Total,1,Total);
END
"""
RACK = 'program = "wide.rung"\nscan_ms = 2\nwatchdog_ms = 0\n\n[[slot]]\nnumber = 1\nmodule = "1769-IQ16"\n'


def test_wide_integers_are_exact(page, tmp_path: Path) -> None:
    (tmp_path / "wide.rung").write_text(PROGRAM, encoding="utf-8")
    (tmp_path / "wide.toml").write_text(RACK, encoding="utf-8")
    with watching(tmp_path / "wide.toml", "--paused", "--time-scale", "max") as session:
        page.open(session.link, paused=True)
        for tag in ("Total", "Most"):
            page.watch(tag)
        page.step(2)
        page.until_scan(1, "paused")
        page.until_value("Most", "18446744073709551615")
        page.until_value("Total", "9007199254740995")
        page.click("//section[@id='watch']//button[text()='Total']", "xpath")
        entry = page.control("New value")
        entry.send_keys("-9223372036854775807")
        page.press("Strip")
        page.press("Write")
        page.step(1)
        page.until_value("Total", "-9223372036854775806")
        assert page.messages() == []
