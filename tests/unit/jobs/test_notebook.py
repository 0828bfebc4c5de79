"""What notebooks and terminals show of traces, statuses, images, rungs and benches: static and small."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import pytest
from scanrack import Image, StatusView, Trace, load_rack, open_bench, open_trace, run
from scanrack.ladder.files import parse_program

FEEDER = Path(__file__).parents[3] / "examples/feeder/feeder.toml"


@pytest.fixture(scope="module")
def trace(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Trace]:
    path = tmp_path_factory.mktemp("notebook") / "a.mcap"
    run(load_rack(FEEDER), scans=2_000, trace=path)
    with open_trace(path) as opened:
        yield opened


def checked(html: str) -> ElementTree.Element:
    """Return HTML that is sound and static: no script, nothing from elsewhere."""
    assert "<script" not in html
    assert "http" not in html.replace("http://www.w3.org/2000/svg", "")
    return ElementTree.fromstring(f"<body>{html}</body>")


def test_a_trace_says_its_name_length_way_and_rules(trace: Trace) -> None:
    assert repr(trace) == "<Trace 'feeder': scans 0 to 1,999>"
    html = trace._repr_html_()
    text = "".join(checked(html).itertext())
    assert "feeder" in text
    assert "2,000 scans, 3.998 s" in text
    assert "CONFIG_ERROR at scan 0" in text
    assert "slot 1: position" in text
    (line,) = checked(html).iter("polyline")
    assert 300 < len(line.attrib["points"].split()) <= 640
    assert len(html) < 20_000


@pytest.mark.slow
@pytest.mark.extra("frames")
def test_a_trace_becomes_frames_and_arrays_without_deep_imports(trace: Trace) -> None:
    words = trace.by_name()
    assert words["slot1"]["in"]["position_lsw"].shape == (2_000,)
    for extra, method in (("pandas", trace.to_pandas), ("polars", trace.to_polars)):
        pytest.importorskip(extra)
        frame = method("slot1.in.MOVE_COMPLETE")
        assert len(frame) == 2_000
        assert "slot1.in.MOVE_COMPLETE" in list(frame.columns)


def test_a_status_shows_its_bits_and_an_image_its_words() -> None:
    image = Image([0x4080, 0, -12, -345])
    view = StatusView(image)
    assert repr(view) == "<StatusView MOVE_COMPLETE MODULE_OK, position -12,345>"
    spans = {each.text: each.attrib["style"] for each in checked(view._repr_html_()).iter("span")}
    assert "font-weight:700" in spans["MOVE_COMPLETE"]
    assert "opacity" in spans["COMMAND_ERROR"]
    cells = [each.text for each in checked(image._repr_html_()).iter("td")]
    assert cells[:4] == ["0", "16,512", "4080h", "7 14"]
    assert cells[8:12] == ["2", "-12", "FFF4h", "2 4 5 6 7 8 9 10 11 12 13 14 15"]


def test_a_rung_is_a_drawing() -> None:
    program = parse_program("PROGRAM a\nTAG Go : BOOL\nTAG Run : BOOL\nROUTINE Main\nXIC(Go)OTE(Run);\nEND\n")
    (rung,) = program.routines[0].rungs
    text = "".join(checked(rung._repr_html_()).itertext())
    assert "Go" in text
    assert "Run" in text


def test_a_bench_shows_scan_status_events_words_and_power() -> None:
    with open_bench(FEEDER) as bench:
        bench.scan(100)
        assert repr(bench) == "<Bench 'feeder': after 100 scans, 0.198 s>"
        body = checked(bench._repr_html_())
    text = "".join(body.itertext())
    assert "after 100 scans, 0.198 s" in text
    assert "in position_msw" in text
    assert "out command_msw" in text
    assert "CONFIG_ERROR" in text
    assert "Awake" in text  # a tag of its rungs


def test_names_from_files_stay_text() -> None:
    from scanrack.io_images.static_html import card, line, rows

    html = card("<script>alert(1)</script>", line("<b>"), rows([("<img onerror=x>", "&")]))
    assert "<script" not in html
    assert "<img" not in html
    assert list(checked(html).iter("img")) == []
