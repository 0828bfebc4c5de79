"""A field of a Python program that a test forces: on record, and in `why` and the chain of what follows."""

import pytest
from scanrack import open_bench, open_trace
from scanrack.traces import TraceEvent

PROGRAM = """from scanrack import Input, Logic, Output


class Line(Logic):
    go = Input("Local:2:I.Data.1")
    lamp: Output = Output("Local:2:O.Data.0")
    count = 0
    seen = 0

    def every_scan(self) -> None:
        if self.go:
            self.count += 1
        self.seen = self.count
        self.lamp = self.seen > 5
"""
RACK = 'program = "line.py"\nscan_ms = 10\n[[slot]]\nnumber = 2\nmodule = "discrete16"\n'
LAMP = "Local:2:O.Data.0"


@pytest.fixture
def bench(tmp_path):
    """Five scans without a force, three with one; `Line` copies the forced field and lights its lamp."""
    (tmp_path / "line.py").write_text(PROGRAM, encoding="utf-8")
    (tmp_path / "line.toml").write_text(RACK, encoding="utf-8")
    with open_bench(tmp_path / "line.toml", tmp_path / "line.mcap") as bench:
        bench.scan(5)
        bench.force("line.count", 7)
        bench.scan(3)
        yield bench


def test_why_and_its_chain_have_the_value_that_the_bench_reads(bench):
    assert bench["line.count"] == 7
    assert bench.why("line.count") == "line.count is 7 since 0.05 s (scan 5): forced to 7 since 0.05 s"
    link = bench.chain("line.count")
    assert (link.kind, link.value, link.scan) == ("force", 7, 5)


def test_what_follows_from_a_forced_field_is_explained(bench):
    assert (bench["line.seen"], bench[LAMP]) == (7, 1)
    for name in ("line.seen", LAMP):
        link = bench.chain(name)
        assert (link.kind, link.value, link.scan) == ("line", 7 if name != LAMP else True, 5)
    assert "self.seen = self.count" in bench.why("line.seen")


def test_a_released_field_keeps_its_value_and_what_forced_it(bench):
    bench.unforce("line.count")
    bench.scan(2)
    assert "is 7 since 0.05 s (scan 5): forced to 7" in bench.why("line.count")
    assert (bench.chain("line.count").kind, bench.chain("line.count").value) == ("force", 7)


def test_the_force_is_on_record(bench, tmp_path):
    bench.unforce("line.count")
    bench.scan(1)
    bench.close()
    with open_trace(tmp_path / "line.mcap") as trace:
        events = [each for each in trace if isinstance(each, TraceEvent) and each.topic == "/forces"]
    assert [(each.scan, dict(each.fields)) for each in events] == [(5, {"tags": {"line.count": 7}}), (8, {})]


def test_inputs_are_tried_on_the_values_that_a_test_has_set(bench):
    """Without the orders of the recording, the count begins at 0, and the lamp needs six scans."""
    bench.unforce("line.count")
    bench["line.count"] = 5
    bench.scan(2)
    (found,) = bench.suggest_inputs("lamp").found
    assert ([each.name for each in found.changes], found.scans) == (["go"], 1)
