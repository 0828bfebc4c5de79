"""The page as a file: what it discloses, how large it gets; and the recording inside, anybody's perhaps."""

from __future__ import annotations

import base64
import hashlib
import json
import re
import zlib
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from recordings import recorded
from scanrack.commands import build
from scanrack.watch.share import page_file
from scanrack.watch.share.command import ShareOptions
from scanrack.watch.share.page_file import GENERATOR, recording_beside
from typer.testing import CliRunner, Result

HOSTILE = "</script><img src=x onerror=alert(1)><!--"
PROGRAM = f"""
PROGRAM count
TAG Count : DINT
ROUTINE Main
// {HOSTILE}
ADD(Count,1,Count);
END
"""


@pytest.fixture(scope="module")
def trace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of 300 scans."""
    return recorded(tmp_path_factory.mktemp("share"), 300, PROGRAM)


def shared(trace: Path, out: Path, *options: str) -> Result:
    return CliRunner().invoke(build(), ["share", str(trace), "-o", str(out), *options])


def data_in(page: Path) -> dict[str, Any]:
    (packed,) = re.findall(r'id="data">([^<]+)<', page.read_text("utf-8"))
    data: dict[str, Any] = json.loads(zlib.decompress(base64.b64decode(packed)))
    return data


class Elements(HTMLParser):
    """Collects what a page has as elements: its scripts by type, and all that would load something."""

    def __init__(self) -> None:
        super().__init__()
        self.loads: list[tuple[str, str | None]] = []
        self.policy = ""
        self.scripts: dict[str | None, str] = {}
        self._kind: str | None = None
        self._inside = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.loads += [
            (tag, given[name]) for name in ("src", "href", "srcset", "data", "action") if name in given
        ]
        if given.get("http-equiv") == "Content-Security-Policy":
            self.policy = given["content"] or ""
        self._inside, self._kind = tag == "script", given.get("id") or given.get("type")

    def handle_data(self, data: str) -> None:
        if self._inside:
            self.scripts[self._kind] = self.scripts.get(self._kind, "") + data

    def handle_endtag(self, tag: str) -> None:
        self._inside = False


def test_the_page_loads_nothing_and_its_policy_names_the_scripts_that_may_run(trace, tmp_path):
    out = tmp_path / "page.html"
    assert shared(trace, out).exit_code == 0
    page = Elements()
    page.feed(out.read_text("utf-8"))
    assert page.loads == [("a", "#program")]  # a place in itself
    assert set(page.scripts) == {"data", "importmap", "module"}
    hashes = set(re.findall(r"'sha256-([^']+)'", page.policy))
    assert hashes == {
        base64.b64encode(hashlib.sha256(page.scripts[kind].encode()).digest()).decode()
        for kind in ("importmap", "module")
    }
    assert "default-src 'none'" in page.policy
    assert "connect-src" not in page.policy
    assert HOSTILE not in out.read_text("utf-8")
    (routine,) = data_in(out)["programs"][0]["shows"].values()
    assert routine["56"]["rungs"][0]["comment"] == HOSTILE


@pytest.mark.parametrize(
    ("given", "kept"),
    [
        ({}, (0, 49_999, 49_999)),  # up to 50,000 scans the whole recording
        ({"scan": 7}, (0, 49_999, 7)),
        ({"time_ns": 14_000_001}, (0, 49_999, 7)),
    ],
)
def test_short_recordings_are_shared_whole(given, kept):
    assert tuple(ShareOptions(**given).within(0, 49_999, 2_000_000)) == kept


@pytest.mark.parametrize("scan", [9, 100_001])
def test_a_scan_that_a_recording_lacks_is_refused_and_its_first_and_last_are_there(scan):
    with pytest.raises(ValueError, match=rf"no scan {scan}: the recording has"):
        ShareOptions(scan=scan).within(10, 100_000, 2_000_000)
    assert [ShareOptions(scan=each).within(10, 100_000, 2_000_000).scan for each in (10, 100_000)] == [
        10,
        100_000,
    ]


@pytest.mark.parametrize(
    ("given", "kept"),
    [
        ({}, (80_000, 100_000, 100_000)),
        ({"scan": 50_000}, (30_000, 52_000, 50_000)),
        ({"scan": 50_000, "before": 10, "after": 0}, (49_990, 50_000, 50_000)),
        ({"scan": 5}, (0, 2_005, 5)),
        ({"scan": 5, "all_scans": True}, (0, 100_000, 5)),
    ],
)
def test_of_long_ones_what_is_around_the_scan(given, kept):
    assert tuple(ShareOptions(**given).within(0, 100_000, 2_000_000)) == kept


def test_what_is_asked_is_shown_first(trace, tmp_path):
    out = tmp_path / "page.html"
    for options, scan in (((), 299), (("--at", "7"), 7), (("--at", "100 ms"), 50)):
        done = shared(trace, out, *options, "--all", "--before", "5", "--after", "5")
        assert done.exit_code == 0, done.output
        assert f"scan {scan} is shown first" in done.output
        assert (data_in(out)["scan"], data_in(out)["range"]) == (scan, [0, 299])
    kept = "1 routine), the words of scans 0 to 299, 1 tag, 3 events, and explanations of 1 value"
    assert kept in done.output


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--at", "300"), "no scan 300: the recording has 0 to 299"),
        (("--at", "3 s 2"), "3 s 2"),
    ],
)
def test_what_can_not_be_shared_leaves_the_page_as_it_was(trace, tmp_path, options, told):
    out = tmp_path / "page.html"
    shared(trace, out)
    before = out.read_bytes()
    done = shared(trace, out, *options)
    assert (done.exit_code, told in done.stderr) == (2, True)
    assert out.read_bytes() == before


def test_a_page_of_more_than_the_limit_is_refused_and_nothing_written(trace, tmp_path, monkeypatch):
    monkeypatch.setattr(page_file, "MOST_BYTES", 100_000)
    done = shared(trace, tmp_path / "page.html")
    assert done.exit_code == 2
    assert "must be at most 100,000: share fewer scans, see --before and --after" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_folders_of_this_machine_are_in_no_page(trace, tmp_path):
    out = tmp_path / "page.html"
    shared(trace, out)
    assert str(trace.parent) not in json.dumps(data_in(out))
    assert data_in(out)["hello"]["record"] == trace.name


def test_the_recording_inside_comes_out_as_it_was(trace, tmp_path):
    out = tmp_path / "page.html"
    done = shared(trace, out, "--with-recording")
    assert "The recording is inside, with the files of its rack and program." in done.output
    assert recording_beside(out) == tmp_path / "page.mcap"
    assert (tmp_path / "page.mcap").read_bytes() == trace.read_bytes()
    assert recording_beside(out) == tmp_path / "page.mcap"  # the same once more


def page_with(recording: str) -> str:
    inside = f'<script type="application/octet-stream" id="recording">{recording}</script>'
    return f"<html>{GENERATOR}{inside}</html>"


@pytest.mark.parametrize(
    ("page", "told"),
    [
        ("<html></html>", "has no recording in it: scanrack share --with-recording puts it there"),
        (page_with("QUJ"), "its recording is damaged"),
        (page_with("QUJD!"), "has no recording in it"),
        (page_with("IyEvYmluL3NoCg=="), "its recording is damaged: it is not an MCAP recording"),
        (page_with("A" * 10_000_000), "is larger than a shared page, 10,000,000 bytes"),
    ],
    ids=["none", "cut off", "other letters", "a script", "too large"],
)
def test_a_page_that_is_not_as_we_write_it_is_refused(tmp_path, page, told):
    out = tmp_path / "page.html"
    out.write_text(page, encoding="utf-8")
    done = CliRunner().invoke(build(), ["watch", str(out), "--port", "0"])
    assert (done.exit_code, told in done.stderr) == (2, True), done.stderr
    assert list(tmp_path.iterdir()) == [out]


def test_another_file_of_that_name_is_kept(trace, tmp_path):
    out, other = tmp_path / "page.html", tmp_path / "page.mcap"
    shared(trace, out, "--with-recording")
    other.write_bytes(b"mine")
    done = CliRunner().invoke(build(), ["watch", str(out), "--port", "0"])
    assert done.exit_code == 2
    assert "page.mcap is another file than the recording in" in done.stderr
    assert other.read_bytes() == b"mine"
