"""Signals by name: what they are read from, what is not one, and that blocks make no difference."""

from __future__ import annotations

import base64
import json
import re
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_traces import A3601, PERIOD_NS, cut_blocks, idle, record
from scanrack.io_images.thousands import join_reported, join_reported_all
from scanrack.traces import SlotInfo, open_trace
from scanrack.traces.export import write_csv, write_vcd
from scanrack.traces.plot import Envelope, read_chart, save_page
from scanrack.traces.signals import Catalog, Selection, SignalKind, blocks
from scanrack.traces.signals.catalog import UnknownSignalError

SLOTS = (A3601, SlotInfo(7, "a toy"))
words16 = st.integers(-32_768, 32_767)


def read(path: Path, name: str, selection: Selection = Selection()) -> list[float]:  # noqa: B008 - it is frozen
    with open_trace(path) as trace:
        signal = Catalog(trace.head.slots)[name]
        return np.concatenate([signal.read(block) for block in blocks(trace, selection)]).tolist()


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    words = idle(200, slots=2)
    words[:, 0] = np.arange(200) % 2  # ABSOLUTE_MOVE in odd scans
    words[:, 2:4] = (-12, -345)
    words[100:, 8] |= 1  # MOVING_CW
    words[:, 11] = np.maximum(0, np.arange(200) - 99) * 4
    words[150:152, 8] = -31_682
    words[:, 29] = np.arange(200) - 100
    return record(tmp_path_factory.mktemp("signals") / "a.mcap", words, SLOTS)


def test_bits_words_and_values(path: Path) -> None:
    assert read(path, "slot1.out.ABSOLUTE_MOVE")[:4] == [False, True, False, True]
    assert read(path, "slot1.out.command_msw")[:4] == [0, 1, 0, 1]
    assert set(read(path, "slot1.out.target")) == {-12_345}
    assert read(path, "slot7.in.word5")[:3] == [-100, -99, -98]
    assert read(path, "slot7.in.word5.15")[98:102] == [True, True, False, False]  # the sign
    assert set(read(path, "cpu.flags")) == {1}
    assert [set(read(path, f"cpu.flags.{bit}")) for bit in (0, 6)] == [{True}, {False}]


def test_configuration_mode_has_no_values_and_three_bits(path: Path) -> None:
    assert np.isnan(read(path, "slot1.in.position")[150:152]).all()
    assert read(path, "slot1.in.MODE_CONFIG")[149:153] == [False, True, True, False]
    assert not any(read(path, "slot1.in.ACCELERATING")[150:152])  # bit 5 is set, and a mirror
    assert read(path, "slot1.in.status_msw.5")[150:152] == [True, True]


@given(words16, words16)
def test_columns_join_words_as_the_codec_does(msw: int, lsw: int) -> None:
    columns = np.array([msw], np.int16), np.array([lsw], np.int16)
    assert join_reported_all(*columns).tolist() == [join_reported(msw, lsw)]


@pytest.mark.parametrize("size", [1, 3, 7, 50, 1000])
def test_blocks_of_any_size_give_the_same(path: Path, size: int, monkeypatch: pytest.MonkeyPatch) -> None:
    names = ("slot1.speed", "slot1.in.position", "slot1.in.MOVING_CW")
    expected = [read(path, name) for name in names]
    cut_blocks(monkeypatch, size)
    for name, values in zip(names, expected, strict=True):
        np.testing.assert_array_equal(read(path, name), values)


def files(path: Path, folder: Path) -> dict[str, str]:
    """Return all that is made of a trace, as text."""
    with open_trace(path) as trace:
        write_csv(trace, folder / "a.csv")
        write_vcd(trace, folder / "a.vcd")
        chart = read_chart(trace, Envelope)
        save_page(trace, folder / "a.html")
    page = json.loads(
        re.findall(r'application/json">(.*?)</script>', (folder / "a.html").read_text(encoding="utf-8"))[0]
    )
    panel = page["panels"][0]
    packed = {each["name"]: unpacked(each["curve"], np.int32) for each in panel.pop("curves")}
    packed |= {"time": unpacked(page.pop("time"), np.float64), "scan": unpacked(page.pop("scan"), np.int32)}
    texts = {name: (folder / name).read_text(encoding="utf-8") for name in ("a.csv", "a.vcd")}
    return texts | {"chart": repr(chart), "page": repr(page), "packed": repr(packed)}


def unpacked(text: str, kind: type) -> list[float]:
    return np.cumsum(np.frombuffer(zlib.decompress(base64.b64decode(text)), kind), dtype=kind).tolist()


@pytest.mark.slow
@pytest.mark.parametrize("size", [1, 7])
def test_blocks_of_any_size_give_the_same_files(
    path: Path, tmp_path: Path, size: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = files(path, tmp_path)
    cut_blocks(monkeypatch, size)
    assert files(path, tmp_path) == expected


@pytest.mark.parametrize(
    ("selection", "first", "last"),
    [
        (Selection(), 0, 199),
        (Selection(first=10, last=20), 10, 20),
        (Selection(start_ns=10 * PERIOD_NS, end_ns=20 * PERIOD_NS), 10, 20),
        (Selection(first=50, start_ns=1, last=180, end_ns=170 * PERIOD_NS + 1), 50, 170),
        (Selection(first=199), 199, 199),
    ],
)
def test_a_selection_is_the_scans_within_its_ends(
    path: Path, selection: Selection, first: int, last: int
) -> None:
    with open_trace(path) as trace:
        found = [scan for block in blocks(trace, selection) for scan in block.scan.tolist()]
    assert found == list(range(first, last + 1))


def test_a_speed_at_the_edge_of_a_selection_is_that_of_the_whole(path: Path) -> None:
    whole = read(path, "slot1.speed")
    assert read(path, "slot1.speed", Selection(first=101, last=103)) == whole[101:104]


def test_every_listed_signal_can_be_read(path: Path) -> None:
    with open_trace(path) as trace:
        catalog = Catalog(trace.head.slots)
        (block,) = blocks(trace, Selection(last=9))
        for name in catalog:
            values = catalog[name].read(block)
            assert len(values) == 10
            assert (values.dtype == bool) == (catalog[name].kind is SignalKind.BIT)


def test_patterns() -> None:
    catalog = Catalog(SLOTS)
    names = [signal.name for signal in catalog.matching(["slot1.in.*_ERROR", "slot1.in.position"])]
    errors = ["slot1.in.INPUT_ERROR", "slot1.in.COMMAND_ERROR", "slot1.in.CONFIG_ERROR"]
    assert names == ["slot1.in.position", *errors]
    assert [signal.name for signal in catalog.matching(["slot7.in.word0.3"])] == ["slot7.in.word0.3"]
    plain = [signal.name for signal in catalog.matching([])]
    assert "slot1.in.position_msw" not in plain
    assert "slot7.out.word0" in plain


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("slot1.in.positon", "did you mean slot1.in.position"),
        ("slot1.in.comand_error", "did you mean slot1.in.COMMAND_ERROR"),
        ("MOVING_CW", "did you mean slot1.in.MOVING_CW or slot1.in.MOVING_CCW?"),
        ("cpu.flags.32", "did you mean cpu.flags"),
        ("slot7.in.word0.16", "did you mean slot7.in.word"),
        ("quite another thing", "the trace has cpu.flags and signals of slot1, slot7"),
    ],
)
def test_an_unknown_name_is_told_with_the_closest(name: str, hint: str) -> None:
    with pytest.raises(UnknownSignalError) as error:
        Catalog(SLOTS)[name]
    assert repr(name) in str(error.value)
    assert hint in str(error.value)
