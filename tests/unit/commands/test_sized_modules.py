"""Modules of 2, of 31, and of 8 + 4 words of a user's own go through every command, to the last word.

Local:2:O.Data[30].0    COUNT, from scan 1 on
Local:2:I.Data[30]      milliseconds since: 2 (n - 1) in scan n, as a scan takes 2 ms
Local:2:O.Data[29]      seven times that; Local:2:I.Data[29] repeats it in the next scan
"""

from __future__ import annotations

import asyncio
import csv
import json
import re
import shutil
import struct
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from scanrack import open_bench, open_trace
from scanrack.commands import COMMANDS, build
from scanrack.jobs import load_job
from scanrack.runtime import CpuFault, RackFileError
from scanrack.testing.modules import ContractError, check_module, record_in
from scanrack.traces.query import query
from served_tags import Client, ServedRack, message, symbol
from typer.testing import CliRunner
from watching import page_of, watched

SUPPORT = Path(__file__).parents[2] / "support"
SCANS = 50
LAST = 2 * (SCANS - 2)  # counted in the last scan

RUNGS = """\
PROGRAM line
TAG Seen : INT
TAG Copied : INT[31]
SLOT big : 2
ROUTINE Main
XIO(S:FS)OTE(big.command.COUNT);
XIO(S:FS)OTE(O:1.1/0);
XIO(S:FS)OTE(Local:3:O.Data[7].0);
MOV(Local:2:I.Data[30],Seen);
MUL(Seen,7,Local:2:O.Data[29]);
COP(Local:2:I.Data[0],Copied[0],31);
MOV(Copied[29],Local:3:O.Data[2]);
XIC(Local:3:I.Data[2].1)OTE(O:1.0/0);
END
"""

PYTHON = '''"""The same as line.rung."""


def logic(scan):
    small, large, mixed = (scan.slot[number] for number in (1, 2, 3))
    if scan.first:
        return
    for slot in (small, large, mixed):
        slot.outputs.set_bit(len(slot.outputs) - 1, 0, True)
    large.outputs[29] = 7 * large.inputs[30]
    mixed.outputs[2] = large.inputs[29]
    small.outputs.set_bit(0, 0, mixed.inputs.bit(2, 1))
'''

RACK = """\
program = "line.{}"
scan_ms = 2
run_for_s = 0.1

[modules]
small = "sized.py:SMALL"
large = "sized.py:LARGE"
mixed = "sized.py:MIXED"

[server]
writable = ["Local:*:O.Data"]

[[slot]]
number = 3
module = "mixed"

[[slot]]
number = 1
module = "small"

[[slot]]
number = 2
module = "large"
"""

MUST = """\
from scanrack import always

@always
def it_counts_to_ten(now):
    return now.slot[2].inputs[30] <= 10 and now.slot[3].outputs[7] in (0, 1)
"""

EVERY: dict[str, tuple[str, ...]] = {  # command: what of it is said of the last words
    "run {}.toml --record {}.mcap -q": (),
    "show {}.mcap": ("+COUNT", f"counted {LAST - 2} -> {LAST}"),
    "query {}.mcap slot2.in.counted>=90": (" 46 ", " 49 "),
    "query {}.mcap slot2.command.COUNT": (" 1 ",),
    "query {}.mcap Local:2:O.Data[30].0": (" 1 ",),
    "plot {}.mcap --out {}.html": ("{}.html",),
    "export {}.mcap --csv {}.csv --jsonl {}.jsonl --vcd {}.vcd --parquet {}.parquet": ("50 scans",),
    "compare {}.mcap forced-{}.mcap": ("slot2.in.in29", "slot2.out.out29"),
    "repair {}.mcap --out {}-again.mcap": ("nothing to repair",),
    "replay {}.mcap": ("the same",),
    "replay --into session {}.mcap": ("identical byte for byte",),
    "replay --into program {}.mcap": ("the same",),
    "why {}.mcap Local:2:O.Data[29]": ("MUL(Seen,7,Local:2:O.Data[29])|large.outputs[29] = 7",),
    "why {}.mcap": ("output word 30 since scan 1", "in29 ", "out7|COUNT"),
    "share {}.mcap --out {}-shared.html": ("shared.html",),
    "check {}.toml": ("no findings",),
    "tags {}.toml": ("Local:1:I.Data   INT[2]", "Local:2:O.Data   INT[31]", "Local:3:I.Data   INT[4]"),
    "watch {}.toml --for 20ms --time-scale max": ("http://",),
    "fuzz {}.toml --for 60ms --runs 4 --jobs 1 --invariants must.py": ("it counts to ten",),
    "ladder rung.toml": ("Local:2:I.Data[30]",),
    "xref rung.toml Seen": ("MOV(Local:2:I.Data[30],Seen)",),
    "prove rung.toml": ("Local:2:O.Data[29]",),
    "editor schema": ("late_words",),
}
"""Without those that have no rack: of controllers on a line, of projects, of captures, of a real 3601."""

ELSEWHERE = {"conform", "debug", "device", "doctor", "drive", "import", "l5x", "new", "rules", "serve"}


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sized")
    shutil.copy(SUPPORT / "sized.py", folder)
    for name, text in {"line.rung": RUNGS, "line.py": PYTHON, "must.py": MUST}.items():
        (folder / name).write_text(text, encoding="utf-8")
    for kind, suffix in (("rung", "rung"), ("py", "py")):
        rack = RACK.format(suffix)
        (folder / f"{kind}.toml").write_text(rack, encoding="utf-8")
        forced = f'{rack}\n[[force]]\naddress = "Local:2:O.Data[29]"\nvalue = 5\n'
        (folder / f"forced-{kind}.toml").write_text(forced, encoding="utf-8")
    return folder


def scanrack(*words: object) -> str:
    done = CliRunner().invoke(build(), list(map(str, words)), catch_exceptions=False)
    assert done.exit_code in (0, 1), done.output
    return done.output


@pytest.fixture(scope="module", params=["rung", "py"])
def recorded(request: pytest.FixtureRequest, place: Path) -> Iterator[str]:
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(place)
        for rack in (request.param, f"forced-{request.param}"):
            scanrack("run", f"{rack}.toml", "--record", f"{rack}.mcap", "-q")
        yield request.param


@pytest.mark.slow
@pytest.mark.parametrize("words", EVERY)
def test_every_command_says_what_is_in_the_last_words(words: str, recorded: str) -> None:
    said = scanrack(*words.replace("{}", recorded).split())
    for each in EVERY[words]:
        either = each.replace("{}", recorded).split("|")
        assert any(one in said for one in either), (each, said)


def test_every_command_is_there() -> None:
    assert {words.split()[0] for words in EVERY} | ELSEWHERE == set(COMMANDS)


def test_a_forced_last_word_is_what_the_module_gets(recorded: str) -> None:
    with open_trace(f"forced-{recorded}.mcap") as trace:
        scans = list(trace.scans())
    assert {scan.outputs(2)[29] for scan in scans} == {5}
    assert {scan.inputs(2)[29] for scan in scans[1:]} == {5}


def _csv(path: str) -> list[Any]:
    with Path(f"{path}.csv").open(encoding="utf-8", newline="") as file:
        return [row["slot2.in.counted"] for row in csv.DictReader(file)]


def _jsonl(path: str) -> list[Any]:
    lines = Path(f"{path}.jsonl").read_text(encoding="utf-8").splitlines()
    return [json.loads(line)["slot2.in.counted"] for line in lines]


def _parquet(path: str) -> list[Any]:
    import pyarrow.parquet as parquet

    return list(parquet.read_table(f"{path}.parquet")["slot2.in.counted"].to_pylist())


def _vcd(path: str) -> list[Any]:
    text = Path(f"{path}.vcd").read_text(encoding="utf-8")
    name = re.search(r"\$var \w+ 16 (\S+) \S*counted", text[text.index("slot2") :])
    assert name is not None
    bits = re.findall(rf"^b([01]+) {re.escape(name[1])}$", text, re.MULTILINE)
    return [int(each, 2) for each in bits]


@pytest.mark.parametrize(
    "read", [_csv, _jsonl, pytest.param(_parquet, marks=pytest.mark.extra("parquet")), _vcd]
)
def test_an_export_has_the_last_word(read: Callable[[str], list[Any]], recorded: str) -> None:
    kinds: dict[Any, str] = {_csv: "csv", _jsonl: "jsonl", _parquet: "parquet", _vcd: "vcd"}
    scanrack("export", f"{recorded}.mcap", f"--{kinds[read]}", f"{recorded}.{kinds[read]}")
    assert int(float(read(recorded)[-1])) == LAST


def test_a_test_of_a_user_reads_forces_and_writes_last_words(place: Path) -> None:
    with open_bench(place / "rung.toml") as bench:
        bench.scan(10)
        assert bench["Local:2:I.Data[30]"] == bench.slot[2].inputs[30] == 16
        bench.force("Local:2:I.Data[30]", 1_000)
        bench.scan()
        assert bench["Seen"] == 1_000
        assert bench.slot[2].outputs[29] == 7_000


@pytest.mark.parametrize(
    ("table", "says"),
    [
        ('[[force]]\naddress = "Local:1:I.Data[2]"\nvalue = 1', "word 2 does not exist: words are 0 to 1"),
        ('[[force]]\naddress = "Local:3:I.Data[4]"\nvalue = 1', "word 4 does not exist: words are 0 to 3"),
        (
            '[[incident]]\nat_ms = 2\nwhat = "torn-update"\nslot = 1\nlate_words = [2]',
            r"late_words \[2\] are not allowed: 0 to 1",
        ),
    ],
)
def test_a_word_that_a_module_does_not_have_is_refused(table: str, says: str, place: Path) -> None:
    rack = place / "wrong.toml"
    rack.write_text(f"{RACK.format('rung')}\n{table}\n", encoding="utf-8")
    with pytest.raises(RackFileError, match=says):
        load_job(str(rack))


def test_a_rung_beyond_the_last_word_is_refused_with_the_size(place: Path) -> None:
    (place / "beyond.rung").write_text(RUNGS.replace("Data[30],Seen", "Data[31],Seen"), encoding="utf-8")
    rack = place / "beyond.toml"
    rack.write_text(RACK.format("rung").replace("line.rung", "beyond.rung"), encoding="utf-8")
    with pytest.raises(RackFileError, match=r"index 31 is outside Local:2:I.Data\[31\]; must be 0 to 30"):
        load_job(str(rack))


def test_a_list_of_steps_writes_all_words_and_names_too_many(place: Path) -> None:
    words = " ".join(map(str, range(1, 32)))
    (place / "line.steps").write_text(f"SLOT 2\nwords {words} for 20 ms\nzero\n", encoding="utf-8")
    rack = place / "steps.toml"
    rack.write_text(RACK.format("steps"), encoding="utf-8")
    with open_bench(rack) as bench:
        bench.scan(2)
        assert list(bench.slot[2].outputs) == list(range(1, 32))
    (place / "line.steps").write_text("SLOT 1\nwords 1 2 3\n", encoding="utf-8")
    with open_bench(rack) as bench, pytest.raises(CpuFault, match="3 words; the module has 2"):
        bench.scan()


def test_a_torn_update_holds_the_last_word_back(place: Path) -> None:
    rack = place / "torn.toml"
    torn = '[[incident]]\nat_ms = 0\nwhat = "torn-update"\nslot = 2\nlate_words = [30]\nfor_ms = 20\n'
    rack.write_text(f"{RACK.format('rung')}\n{torn}", encoding="utf-8")
    with open_bench(rack) as bench:
        bench.scan(30)
        assert (bench.slot[1].inputs[1], bench.slot[2].inputs[30]) == (56, 36)  # COUNT came 20 ms late


def test_clients_of_the_tags_read_and_write_the_last_word(place: Path) -> None:
    with ExitStack() as ports:
        rack = ServedRack(place / "py.toml", ports)
        client = Client(rack)
        rack.run.cpu.run(10)
        status, data = client.ask(message(0x4C, symbol("Local:2:I", "Data", 30), b"\1\0"))
        assert (status, *struct.unpack("<Hh", data)) == (0, 0xC3, rack.run.rack.slots[2].inputs[30])
        assert data[2:] != b"\0\0"
        write = message(0x4D, symbol("Local:2:O", "Data", 28), struct.pack("<HHh", 0xC3, 1, -123))
        assert client.ask(write)[0] == 0
        rack.run.cpu.run(2)
        assert (rack.run.rack.slots[2].outputs[28], rack.run.rack.slots[2].inputs[28]) == (-123, -123)
        for path in (symbol("Local:1:I", "Data", 2), symbol("Local:2:I", "Data", 31)):
            assert client.ask(message(0x4C, path, b"\1\0"))[0] == 255, "access beyond the end of the object"


@pytest.mark.slow
def test_a_page_shows_forces_and_tears_last_words(place: Path) -> None:
    async def play() -> None:
        with watched("--for", "100s", rack=place / "rung.toml", cwd=place) as session:
            async with page_of(session) as page:
                await page.until(lambda seen: "words" in seen.frame)
                sizes = {slot["number"]: slot["words"] for slot in page.hello["slots"]}
                assert sizes == {3: {"in": 4, "out": 8}, 1: {"in": 2, "out": 2}, 2: {"in": 31, "out": 31}}
                await page.ask("force", tag="Local:2:O.Data[29]", value=77)
                late = {"kind": "torn-update", "slot": 2, "late_words": [30]}
                assert not (await page.ask("incident", **late)).get("refused")
                wrong = await page.ask("incident", kind="torn-update", slot=1, late_words=[2])
                assert "late_words [2] are not allowed: 0 to 1" in str(wrong)
                await page.until(lambda seen: seen.frame["words"]["2"][29] == 77)
                words = page.frame["words"]["2"]
                assert len(words) == 62
                assert (words[31 + 29], words[61]) == (77, 1)
                assert words[30] > 0

    asyncio.run(play())


@pytest.mark.parametrize("name", ["SMALL", "LARGE", "MIXED"])
def test_the_kit_of_authors_takes_any_size(name: str) -> None:
    check_module(record_in(SUPPORT / "sized.py", name), seeds=range(5))


def test_the_kit_names_a_module_that_returns_another_size(tmp_path: Path) -> None:
    source = (SUPPORT / "sized.py").read_text(encoding="utf-8")
    (tmp_path / "short.py").write_text(
        source.replace("Image(size=inputs)", "Image(size=max(1, inputs - 1))"), encoding="utf-8"
    )
    with pytest.raises(ContractError, match="names 31 input words and returns 30"):
        check_module(record_in(tmp_path / "short.py", "LARGE"), seeds=range(2))


def test_a_condition_of_a_query_counts_the_last_word(recorded: str) -> None:
    with open_trace(f"{recorded}.mcap") as trace:
        found = query(trace, "slot2.in.counted == slot1.in.counted and slot2.in.counted == slot3.in.counted")
    assert found is not None
