"""The page in a real browser: it shows what was recorded, and zooms."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_traces import PERIOD_NS, idle, record
from scanrack.traces.plot import save_page
from scanrack.traces.reader import open_trace

SCANS = 5000
BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
needs_browser = pytest.mark.skipif(BROWSER is None, reason="no Chromium is installed")


def write_page(folder: Path) -> Path:
    words = idle(SCANS)
    words[1000:4000, 8] |= 1  # MOVING_CW
    words[2500, 8] |= 0x1000  # COMMAND_ERROR, for one scan
    position = np.clip(np.arange(SCANS) - 999, 0, 3000) * 3
    words[:, 10], words[:, 11] = position // 1000, position % 1000
    words[4900:, 8] = -31_682  # configuration mode
    name = {"name": "</script><b>& a rack"}
    path = record(folder / "a.mcap", words, metadata=name, chunk_scans=700)
    with open_trace(path) as trace:
        save_page(trace, folder / "a.html")
    return folder / "a.html"


def test_the_page_asks_nothing_of_a_network(tmp_path: Path) -> None:
    text = write_page(tmp_path).read_text(encoding="utf-8")
    assert not re.findall(r"https?:|src=|href=|@import|fetch\(", text)
    assert "<h1>&lt;/script&gt;&lt;b&gt;&amp; a rack</h1>" in text
    assert text.count("</script>") == 2


def run(page: Path, script: str, hash_: str = "") -> dict[str, Any]:
    """Open the page, run a script in it once it is ready, and return what it reports."""
    probe = f"""<script>
    const probe = async () => {{
      while (!document.body.dataset.ready) await new Promise(done => setTimeout(done, 5));
      const frame = () => new Promise(done => requestAnimationFrame(() => setTimeout(done)));
      const box = canvas.getBoundingClientRect();
      const report = {{}};
      {script}
      document.body.append(Object.assign(document.createElement("pre"),
        {{ id: "report", textContent: "REPORT" + JSON.stringify(report) + "END" }}));
    }};
    probe().catch(error => document.body.append("REPORT" + JSON.stringify({{error: String(error)}}) + "END"));
    </script></body>"""
    probed = page.with_name("probed.html")
    text = page.read_text(encoding="utf-8").replace("</body>", probe)
    probed.write_text(text, encoding="utf-8")
    assert BROWSER is not None
    done = subprocess.run(
        [BROWSER, "--headless", "--no-sandbox", "--disable-gpu", "--window-size=1300,800",
         f"--user-data-dir={page.parent / 'profile'}", "--virtual-time-budget=8000", "--dump-dom",
         f"{probed.as_uri()}{hash_}"],
        capture_output=True, text=True, timeout=60, check=True,
    )  # fmt: skip
    found = re.search(r"REPORT(\{.*?\})END</pre>", done.stdout) or re.search(
        r"REPORT(\{.*?\})END", done.stdout
    )
    assert found is not None, done.stdout[-2000:]
    report: dict[str, object] = json.loads(
        found[1].replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&")
    )
    assert "error" not in report, report
    return report


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_page(tmp_path_factory.mktemp("page"))


@needs_browser
def test_every_scan_is_in_the_page_as_it_was_recorded(page: Path) -> None:
    report = run(
        page,
        """
        const rows = [0, 999, 1000, 2000, 4500, 4899, 4950];
        report.time = rows.map(row => time[row]);
        report.scan = rows.map(row => scan[row]);
        report.position = rows.map(row => data.panels[0].position.values[row]);
        report.speed = rows.map(row => data.panels[0].speed.values[row]);
        report.count = time.length;
        const lane = data.panels[0].lanes.find(lane => lane.name === "COMMAND_ERROR");
        report.lane = [2499, 2500, 2501].map(row => valueAt(lane, row));
        """,
    )
    rows = [0, 999, 1000, 2000, 4500, 4899, 4950]
    missing = -(2**31)
    assert report["count"] == SCANS
    assert report["time"] == [row * PERIOD_NS for row in rows]
    assert report["scan"] == rows
    assert report["position"] == [0, 0, 3, 3003, 9000, 9000, missing]
    assert report["speed"][3] == 1500  # 3 steps in 2 ms
    assert report["lane"] == [0, 1, 0]


@needs_browser
def test_wheel_drag_and_double_click(page: Path) -> None:
    report = run(
        page,
        """
        const at = x => ({ clientX: box.left + x, clientY: box.top + 60, bubbles: true, pointerId: 1 });
        canvas.setPointerCapture = () => {};
        const middle = LEFT + width() / 2;
        report.all = { ...view };
        canvas.dispatchEvent(new WheelEvent("wheel", { ...at(middle), deltaY: -600 }));
        await frame();
        report.zoomed = { ...view };
        report.drawn = [Number(canvas.dataset.start), Number(canvas.dataset.end)];
        canvas.dispatchEvent(new PointerEvent("pointerdown", at(middle)));
        canvas.dispatchEvent(new PointerEvent("pointermove", at(middle - 100)));
        canvas.dispatchEvent(new PointerEvent("pointerup", at(middle - 100)));
        await frame();
        report.moved = { ...view };
        report.hash = location.hash;
        canvas.dispatchEvent(new MouseEvent("dblclick", at(middle)));
        await frame();
        report.back = { ...view };
        """,
    )
    end = (SCANS - 1) * PERIOD_NS
    assert report["all"] == report["back"] == {"start": 0, "end": end}
    zoomed, moved = report["zoomed"], report["moved"]
    assert zoomed["end"] - zoomed["start"] == pytest.approx(end * 1.0015**-600)
    assert (zoomed["start"] + zoomed["end"]) / 2 == pytest.approx(end / 2)  # around the pointer
    assert report["drawn"] == [zoomed["start"], zoomed["end"]]
    assert moved["start"] > zoomed["start"]  # dragged to the left: what is later comes in
    assert moved["end"] - moved["start"] == pytest.approx(zoomed["end"] - zoomed["start"])
    assert report["hash"].startswith("#from=")


@needs_browser
def test_the_readout_tells_the_scan_under_the_pointer(page: Path) -> None:
    report = run(
        page,
        """
        canvas.dispatchEvent(new PointerEvent("pointermove",
          { clientX: box.left + xOf(2500 * 2e6 + 1), clientY: box.top + 60, bubbles: true }));
        await frame();
        report.text = readout.textContent;
        """,
        "#from=4.99&to=5.01",
    )
    text = report["text"]
    assert "time5.000000 sscan2,500" in text
    assert "position4,503" in text
    assert "constant speed" in text
    assert "status: MOVING_CW MODULE_OK" in text
    assert "error: COMMAND_ERROR" in text
