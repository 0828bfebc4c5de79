"""The lists of changes in a shared page give the values that the monitor shows.

The decoder here is written from the form that `changes` describes, as the page's own is.
Broken on purpose: columns added along the wrong way, names of a changed array left out, a walk without values
before its first scan, a first run left out in spite of an order: a test turns red.
"""

from __future__ import annotations

import base64
import json
import random
import re
import zlib
from itertools import accumulate
from pathlib import Path
from types import SimpleNamespace

import pytest
from recordings import opened
from scanrack.jobs import JobRun, RunOptions, load_job
from scanrack.watch.monitors.page import Page
from scanrack.watch.share.collecting import SharedStretch, collect
from scanrack.watch.share.page_file import page_of

EXAMPLES = Path(__file__).parents[3] / "examples"
RACK = """
name = "arrays"
program = "arrays.rung"
[[slot]]
number = 1
module = "amci3601"
"""
ARRAYS = """
PROGRAM arrays
TAG Table : DINT[8]
TAG Count : DINT
TAG Wide : LREAL
TAG At : DINT
TAG Clock : TIMER
ROUTINE Main
ADD(Count,1,Count) AND(Count,7,At) ADD(Table[At],Count,Table[At]) DIV(Count,3,Wide);
XIO(Clock.DN)TON(Clock,20,0);
END
"""
RACKS = {
    "arrays": None,
    "feeder": EXAMPLES / "feeder/feeder.toml",
    "labeller": EXAMPLES / "sequences/labeller.toml",
    "indexer": EXAMPLES / "l5x/indexer.toml",
}


def recorded(rack: Path, trace: Path, scans: int) -> Path:
    from contextlib import ExitStack

    with ExitStack() as ports:
        JobRun(load_job(str(rack)), ports, RunOptions(trace=trace)).run(scans)
    return trace


def data_in(page: bytes) -> dict:
    (packed,) = re.findall(rb'id="data">([^<]+)<', page)
    return json.loads(zlib.decompress(base64.b64decode(packed)))


def value_at(data: dict, key: str, scan: int):
    """Return a value from its list, or None before the first one."""
    each = data["lists"].get(key)
    if each is None:
        return None
    scans = list(accumulate(each["steps"], initial=data["lead"]))[1:]
    place = max((place for place, change in enumerate(scans) if change <= scan), default=None)
    if place is None:
        return None
    if "values" in each:
        return each["values"][place]
    if "differences" in each:
        return sum(each["differences"][: place + 1])
    return [sum(column[: place + 1]) for column in each["columns"]]


def arrays_in(folder: Path) -> Path:
    (folder / "arrays.toml").write_text(RACK, encoding="utf-8")
    (folder / "arrays.rung").write_text(ARRAYS, encoding="utf-8")
    return folder / "arrays.toml"


def test_a_walk_from_the_first_scan_on_needs_no_run_before_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    trace = recorded(arrays_in(tmp_path), tmp_path / "run.mcap", 140)
    pages, indexed = [], []
    for number in range(3):
        with opened(trace, tmp_path / f"files{number}") as seen:
            monitor = seen.monitor
            if number == 1:
                monkeypatch.setattr(monitor, "run_once", lambda: None)
            if number == 2:
                orders = [SimpleNamespace(scan=1000, order=None)]
                monkeypatch.setattr(monitor._recorded, "orders", lambda _first, _last, told=orders: told)
            pages.append(page_of(collect(monitor, SharedStretch(0, 139, 130))))
            indexed.append(monitor._indexer is not None)
    assert indexed == [False, True, True]
    assert pages[0] == pages[1] == pages[2]


@pytest.mark.slow
@pytest.mark.parametrize("name", RACKS)
def test_any_scan_shows_what_the_monitor_shows(name: str, tmp_path: Path) -> None:
    rack = RACKS[name]
    if rack is None:
        rack = arrays_in(tmp_path)
    trace = recorded(rack, tmp_path / "run.mcap", 600)
    with opened(trace, tmp_path / "files") as seen:
        monitor = seen.monitor
        data = data_in(page_of(collect(monitor, SharedStretch(40, 590, 500))))
        assert (data["range"], data["scan"]) == ([40, 590], 500)
        program = monitor.subject.programs.at(500)
        routines = [each["name"] for each in data["programs"][0]["described"]["routines"]]
        tags = tuple(each["name"] for each in data["programs"][0]["described"]["tags"])
        checked = 0
        for scan in [40, 590, *random.Random(7).sample(range(40, 591), 40)]:
            for routine in routines if program.catalog is not None else [""]:
                page = Page()
                page.program, page.past = program, scan
                if routine and program.catalog is not None:
                    page.show(program.catalog.show(routine, 56)[0])
                page.watch(tags)
                frame = json.loads(json.dumps(monitor.frame(page)))
                for slot, words in frame["words"].items():
                    assert [value_at(data, f"words\n{slot}\n{at}", scan) for at in range(16)] == words
                    checked += 16
                for part in ("power", "tags"):
                    for key, value in frame.get(part, {}).items():
                        assert value_at(data, f"{part}\n0\n{key}", scan) == value, (part, key, scan)
                        checked += 1
                for part in ("mode", "forced", "lines", "rules", "faults"):
                    assert value_at(data, part, scan) == frame[part], (part, scan)
                assert scan * data["hello"]["period_ns"] + (value_at(data, "offset", scan) or 0) == frame["t"]
        assert checked > 40 * 17
