"""Compare with: the same scan of another recording, and the way to the next difference.

Two programs count their scans; the second one counts two from scan 100 on:

    scan       98   99  100  101  ...   s
    one        99  100  101  102      s + 1
    two        99  100  102  104      2 s - 98

Broken on purpose: the scan before in place of the scan, words of the outputs left out: a test turns red.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import nullcontext
from datetime import datetime
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from recordings import Opened, opened, recorded
from scanrack.watch.monitors import comparison
from scanrack.watch.monitors.questions import handle_message as ask
from scanrack.watch.recorded_session import open_beside

SCANS = 300
PROGRAM = """
PROGRAM count
TAG Count : DINT
TAG Even : BOOL
ROUTINE Main
ADD(Count,1,Count);
{more}
MOV(Count,Local:1:O.Data[7]);
XIO(Even)OTE(Even);
END
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The recordings one.mcap and two.mcap."""
    place = tmp_path_factory.mktemp("compared")
    for name, more in (("two", "GEQ(Count,101)ADD(Count,1,Count);"), ("one", "XIO(Even)NOP();")):
        recorded(place, SCANS, PROGRAM.format(more=more)).rename(place / f"{name}.mcap")
    return place


@pytest.fixture
def seen(folder: Path, tmp_path: Path) -> Iterator[Opened]:
    with opened(folder / "one.mcap", tmp_path) as found:
        found.monitor.opener = open_beside
        found.settle()
        asked(found, "show", routine="Main", columns=88)
        yield found
        found.page.compare(None)


def asked(seen: Opened, what: str, **fields: Any) -> Any:
    """Ask; return the answer."""
    seen.page.outbox.clear()
    ask(seen.monitor, seen.page, {"id": 1, "do": what, **fields})
    return seen.page.outbox[-1]["answer"]


def other(seen: Opened, scan: int) -> Any:
    """Return what a frame has of the other recording in a scan."""
    while seen.monitor.tick_compared():
        pass
    return seen.look(scan)["other"]


def test_recordings_of_the_folder_are_offered_and_no_other_file(seen: Opened, folder: Path) -> None:
    (listed,) = asked(seen, "recordings")["recordings"]
    assert (listed["name"], listed["relation"], listed["scan"]) == ("two.mcap", "", None)
    changed = datetime.fromtimestamp((folder / "two.mcap").stat().st_mtime).astimezone()
    assert datetime.fromisoformat(listed["date"]) == changed.replace(microsecond=0)
    for name in ("one.mcap", "../compared0/two.mcap", "count.toml", str(folder / "two.mcap"), 7, "none.mcap"):
        assert "no recording" in asked(seen, "compare", **{"with": name})["refused"]
    assert seen.page.compared is None


def test_a_scan_tells_what_the_other_one_has(seen: Opened) -> None:
    assert asked(seen, "compare", **{"with": "two.mcap"})["with"] == "two.mcap"
    assert other(seen, 99) == {"there": True, "known": True, "words": {}, "power": {}, "tags": {}}
    for scan in (100, 101, 250):
        found = other(seen, scan)
        assert found["tags"] == {"Count": 2 * scan - 98, "Local:1:O.Data[7]": 2 * scan - 98}
        assert found["words"] == {"1": {"15": 2 * scan - 98}}
    assert seen.look(100)["tags"]["Count"] == 101


def test_the_next_difference_is_where_other_words_differ(seen: Opened) -> None:
    asked(seen, "compare", **{"with": "two.mcap"})
    assert asked(seen, "difference", **{"from": 0, "way": 1})["scan"] == 100
    assert asked(seen, "difference", **{"from": 100, "way": 1})["scan"] is None
    assert asked(seen, "difference", **{"from": 250, "way": -1})["scan"] == 100
    assert asked(seen, "difference", **{"from": 100, "way": -1})["scan"] is None


def test_both_have_lanes(seen: Opened) -> None:
    asked(seen, "compare", **{"with": "two.mcap"})
    strip = asked(seen, "beside", **{"from": 90, "to": 110})["strip"]
    assert (strip["from"], strip["to"]) == (90 * 2_000_000, 111 * 2_000_000)


def test_without_another_recording_nothing_is_compared(seen: Opened) -> None:
    asked(seen, "compare", **{"with": "two.mcap"})
    assert asked(seen, "compare", **{"with": None})["with"] is None
    seen.frame.pop("other", None)
    assert "other" not in seen.look(120)
    for question in ("difference", "beside"):
        told = asked(seen, question, **{"from": 1, "to": 2, "way": 1})
        assert told["refused"] == "this page does not compare with a recording"


def test_a_shorter_recording_does_not_have_all_scans(tmp_path: Path) -> None:
    for name, scans in (("short", 50), ("long", 90)):
        recorded(tmp_path, scans, PROGRAM.format(more="")).rename(tmp_path / f"{name}.mcap")
    with opened(tmp_path / "long.mcap", tmp_path / "files") as seen:
        seen.monitor.opener = open_beside
        seen.settle()
        asked(seen, "compare", **{"with": "short.mcap"})
        assert other(seen, 49)["there"]
        assert not other(seen, 50)["there"]
        seen.page.compare(None)


def test_a_file_that_is_no_recording_is_refused(tmp_path: Path) -> None:
    recorded(tmp_path, 20, PROGRAM.format(more=""))
    (tmp_path / "bad.mcap").write_bytes(b"no recording")
    with opened(tmp_path / "count.mcap", tmp_path / "files") as seen:
        seen.monitor.opener = open_beside
        assert "bad.mcap" in asked(seen, "compare", **{"with": "bad.mcap"})["refused"]


@pytest.mark.parametrize(
    ("metadata", "module", "parent", "wanted"),
    [
        ({"name": "count"}, "amci3601", None, ("", None)),
        ({"name": "count"}, "amci3601", "other.mcap", ("parent", None)),
        ({"name": "count", "parent": "own.mcap", "parent_scan": "12"}, "amci3601", None, ("branch", 12)),
        ({"name": "press"}, "amci3601", None, None),
        ({"name": "count"}, "1769-IQ16", None, None),
    ],
)
def test_other_racks_are_not_listed_and_a_parent_and_a_branch_are_marked(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    seen: Opened,
    metadata: dict[str, str],
    module: str,
    parent: str | None,
    wanted: tuple[str, int | None] | None,
) -> None:
    head = SimpleNamespace(metadata=metadata, slots=[SimpleNamespace(number=1, module=module)])
    monkeypatch.setattr(comparison, "open_trace", lambda _path: nullcontext(SimpleNamespace(head=head)))
    (tmp_path / "other.mcap").touch()
    spec = seen.monitor.subject.spec
    found = comparison.described(tmp_path / "other.mcap", spec, tmp_path / "own.mcap", parent)
    assert (found and (found["relation"], found["scan"])) == wanted


def test_what_differs_from_the_first_scan_on_is_found(tmp_path: Path) -> None:
    for name, start in (("zero", 0), ("seven", 7)):
        program = PROGRAM.format(more="").replace("TAG Count : DINT", f"TAG Count : DINT := {start}")
        recorded(tmp_path, 50, program).rename(tmp_path / f"{name}.mcap")
    with opened(tmp_path / "zero.mcap", tmp_path / "files") as seen:
        seen.monitor.opener = open_beside
        seen.settle()
        asked(seen, "compare", **{"with": "seven.mcap"})
        assert asked(seen, "difference", **{"from": -1, "way": 1})["scan"] == 0
        seen.page.compare(None)
