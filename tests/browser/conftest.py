"""A browser for all tests of this folder, and what they look at."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from watched_page import Look, Session, open_browser, watching, why_not

FEEDER = Path(__file__).parents[2] / "examples" / "feeder"


@pytest.fixture(scope="session")
def _browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Look]:
    missing = why_not()
    if missing is not None:
        pytest.skip(missing)
    browser = open_browser(tmp_path_factory.mktemp("profile"))
    yield Look(browser)
    browser.quit()


@pytest.fixture
def page(_browser: Look) -> Iterator[Look]:
    """The browser, its window and colors as they were; it keeps nothing from one test to the next."""
    _browser.look(1600, 1000)
    _browser.messages()
    yield _browser
    if _browser.browser.current_url.startswith("http"):
        _browser.run("localStorage.clear()")
    _browser.browser.get("about:blank")
    _browser.look(1600, 1000)


@pytest.fixture(scope="session")
def feeder_rack(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The feeder's rack file without a watchdog: a busy machine is not a reason for a fault."""
    text = (FEEDER / "feeder.toml").read_text(encoding="utf-8")
    rack = tmp_path_factory.mktemp("feeder") / "feeder.toml"
    program = (FEEDER / "feeder.rung").as_posix()
    rack.write_text(f"watchdog_ms = 0\n{text.replace('feeder.rung', program)}", encoding="utf-8")
    return rack


@pytest.fixture(scope="session")
def running_rack(feeder_rack: Path) -> Path:
    """The same without the rack's own emergency stop at 8 s, for racks that run in real time.

    It may come before, while or after a test presses and waits, as the machine is busy; a page that is
    opened just then stays at its scan.
    """
    text = feeder_rack.read_text(encoding="utf-8")
    rack = feeder_rack.with_name("running.toml")
    rack.write_text(text[: text.index("timeline")], encoding="utf-8")
    return rack


@pytest.fixture(scope="module")
def feeder(running_rack: Path) -> Iterator[Session]:
    """A feeder that runs in real time."""
    missing = why_not()
    if missing is not None:
        pytest.skip(missing)
    with watching(running_rack) as session:
        yield session


@pytest.fixture
def paused(feeder_rack: Path) -> Iterator[Session]:
    """A feeder that stands before its first scan; it runs as fast as it can."""
    missing = why_not()
    if missing is not None:
        pytest.skip(missing)
    with watching(feeder_rack, "--paused", "--time-scale", "max") as session:
        yield session
