"""Compare with another recording: the band, marked rungs, and the key for the next difference.

Two programs count their scans; the lamp of the second one is on from scan 100 on, where Count becomes 101.
"""

import pytest
from scanrack.commands import build
from typer.testing import CliRunner, Result
from watched_page import until, watching, why_not

PROGRAM = """
PROGRAM lamp
TAG Lamp : BOOL
TAG Count : DINT
ROUTINE Main
ADD(Count,1,Count);
GEQ(Count,%d)OTE(Lamp);
XIC(Lamp)MOV(7,Local:1:O.Data[7]);
END
"""
RACK = 'name = "lamp"\nprogram = "lamp.rung"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n'


def run(*words: object) -> Result:
    done = CliRunner().invoke(build(), [str(each) for each in words])
    assert done.exit_code == 0, done.output
    return done


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The recordings dark.mcap and lit.mcap."""
    missing = why_not()
    if missing is not None:
        pytest.skip(missing)
    place = tmp_path_factory.mktemp("compared")
    (place / "lamp.toml").write_text(RACK, "utf-8")
    for name, limit in (("dark", 1000), ("lit", 101)):
        (place / "lamp.rung").write_text(PROGRAM % limit, "utf-8")
        run("run", place / "lamp.toml", "--scans", 400, "--record", place / f"{name}.mcap", "-q")
    return place


def test_it_opens_at_the_first_difference_and_the_band_tells_what_differs_since_when(page, folder):
    with watching(f"{folder / 'dark.mcap'}#scan=10") as session:
        page.open(session.link)
        page.until_scan(10, "past")
        page.press("Compare with a recording")
        page.until_there("[aria-label='Compare with lit.mcap']")
        page.press("Compare with lit.mcap")
        page.until_there("#compared:not([hidden])")
        page.until_scan(100, "past")
        first = "return document.querySelector('#compared .row').textContent"
        until(lambda: "differs since scan 100, 00:00.200: Lamp" in page.run(first))
        page.run("import('/scrub.js').then(scrub => scrub.lookAt(10))")
        page.until_scan(10, "past")
        page.press("Next difference")
        page.until_scan(100, "past")
        page.until_there("#compared[data-words='1']")
        page.until_there("#program [data-at='Main.2'][data-differs]")
        page.until_there("#compared [data-tag='Lamp']")
        differing = "return [...document.querySelectorAll('#compared li')].map(each => each.textContent)"
        assert "Lamp 0, there 1" in page.run(differing)
        page.press("Previous difference")
        page.press("Compare no longer")
        page.until_there("#compared[hidden]")
        assert page.run("return document.querySelector('[data-differs]')") is None
        assert page.messages() == []
