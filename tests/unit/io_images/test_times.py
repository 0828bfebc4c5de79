"""Times as text: one reader and one writer, wherever a time is given or shown."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from collections.abc import Callable
from decimal import Decimal
from pathlib import Path

import pytest
from hypothesis import given as each_of
from hypothesis import strategies as st
from scanrack.io_images.times import (
    LONGEST_NS,
    UNITS_NS,
    exact_ns,
    milliseconds,
    parse_duration,
    parse_time,
    seconds,
    seconds_column,
    time_text,
)
from scanrack.jobs.fuzz.invariants.invariants import eventually
from scanrack.jobs.load.loading import scans_to_run
from scanrack.ladder.files import parse_program
from scanrack.ladder.files.steps import parse_steps
from scanrack.ladder.model.stubs import parse_stub
from scanrack.ladder.python.sequences.blocks import Timer
from scanrack.ladder.python.sequences.waits import dwell
from scanrack.terminal.shared_options import parse_time_range
from scanrack.traces import SlotInfo
from scanrack.traces.query.language import parse
from scanrack.traces.signals.catalog import Catalog

CONTROLLER = "CONTROLLER C\nTASK T : PERIODIC {} RUNS P\nPROGRAM P\nROUTINE Main\nEND\nEND PROGRAM\n"
WEB = Path(__file__).parents[3] / "scanrack/watch/web"
TIMES = st.integers(0, LONGEST_NS)


@each_of(TIMES)
def test_what_is_written_is_read_back(time_ns):
    assert parse_time(time_text(time_ns)) == time_ns
    assert parse_time(f"{seconds(time_ns)} s") == parse_time(f"{seconds_column(time_ns)} s") == time_ns
    assert parse_time(f"{milliseconds(time_ns)} ms") == time_ns


@each_of(st.sampled_from(sorted(UNITS_NS)), st.decimals(0, 1000, places=6), st.sampled_from(["", " ", "  "]))
def test_every_unit_is_exact_or_refused(unit, number, space):
    """Whole nanoseconds by arithmetic of integers: 6 decimals are millionths of the unit."""
    whole, rest = divmod(int(number * 10**6) * UNITS_NS[unit], 10**6)
    text = f" {number:f}{space}{unit} "
    if rest:
        with pytest.raises(ValueError, match=re.escape(f"{text!r} is not a whole number of nanoseconds")):
            parse_time(text)
    else:
        assert parse_time(text) == whole
        assert exact_ns(number, unit) == whole


@pytest.mark.parametrize(
    ("time_ns", "text"),
    [
        (0, "0 s"),
        (5, "5 ns"),
        (400, "400 ns"),
        (1_500, "1.5 µs"),
        (20_000_000, "20 ms"),
        (999_999_999, "999.999999 ms"),
        (1_000_000_001, "1.000000001 s"),
        (5_400_000_000_000, "5400 s"),
        (-2_500_000, "-2.5 ms"),
    ],
)
def test_the_unit_is_the_largest_that_is_filled(time_ns, text):
    assert time_text(time_ns) == text


READERS: dict[str, Callable[[str], object]] = {
    "--for": lambda text: scans_to_run(None, text, None, endless=False),  # type: ignore[arg-type]
    "--range": lambda text: parse_time_range(f"{text}:"),
    "sequence": dwell,
    "timer": Timer,
    "invariant": lambda text: eventually(text, after=bool),
    "steps": lambda text: parse_steps(f"zero for {text}\nzero"),
    "query": lambda text: parse(f"slot1.in.STOPPED for {text}", Catalog([SlotInfo(1, "amci3601")])),
}


@pytest.mark.parametrize("read", READERS.values(), ids=READERS)
@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("1.5 ns", "'1.5 ns' is not a whole number of nanoseconds"),
        ("0.0000000001 s", "'0.0000000001 s' is not a whole number of nanoseconds"),
        (
            "999999999999 h",
            "'999999999999 h' is longer than 146 years, the longest time",
        ),
    ],
)
def test_every_reader_refuses_the_same_in_the_same_words(read, text, says):
    with pytest.raises(ValueError, match=re.escape(says)):
        read(text)


READS: dict[str, Callable[[str], int]] = {
    "option": parse_duration,
    "range": lambda text: parse_time_range(f"{text}:")[0],
    "sequence": lambda text: dwell(text).length_ns,
    "timer": lambda text: Timer(text).preset_ns,
    "steps": lambda text: int(parse_steps(f"zero for {text}\nzero").steps[0].for_ns or 0),
    "stub": lambda text: parse_stub(f"done after {text}").after_ns,  # type: ignore[union-attr]
    "task": lambda text: (
        parse_program(CONTROLLER.format(text)).tasks[0].rate_ns  # type: ignore[union-attr]
    ),
}


@pytest.mark.parametrize("read", READS.values(), ids=READS)
@pytest.mark.parametrize("text", ["50 ms", "50  ms", "50ms", "0.05 s", "50000 us", "50000µs", "50000000 ns"])
def test_every_reader_takes_the_same_forms(read, text):
    assert read(text) == 50_000_000


@pytest.mark.parametrize("text", ["", "10", "s", "-1 s", "1e3 ms", "9 weeks", "1. s", ".5 s", "1,0 s", "١ s"])
def test_what_is_no_time_is_named_with_the_units(text):
    with pytest.raises(ValueError, match=r"is not a time: write a number and a unit .*'10 s'"):
        parse_time(text)


@pytest.mark.parametrize(
    "number", [Decimal("1e-999999999"), Decimal("1." + "0" * 40 + "1"), Decimal("0.0000001"), 1.0000000001]
)
def test_a_number_of_a_key_is_never_rounded(number):
    with pytest.raises(ValueError, match="is not a whole number of nanoseconds"):
        exact_ns(number, "ms", "scan_ms")


def test_the_page_writes_the_same():
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed")
    times = [0, 1, 400, 1_500, 999_999, 20_000_000, 1_502_250_000, 90_000_000_000, 2**53 - 1]
    script = (
        "let text = ''; for await (const part of process.stdin) text += part;"
        f"const {{ timeText }} = await import({json.dumps((WEB / 'format.js').as_uri())});"
        "console.log(JSON.stringify(JSON.parse(text).map(timeText)));"
    )
    command = [node, "--no-warnings", "--input-type=module", "--eval", script]
    done = subprocess.run(
        command, input=json.dumps(times), capture_output=True, encoding="utf-8", check=False
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == [time_text(each) for each in times]
