"""The progress bar, drawn on a screen that is said to be a terminal."""

import io

import pytest
from rich.console import Console
from scanrack.runtime import Cpu, Rack
from scanrack.terminal.progress import shown_progress
from scanrack.terminal.progress_bar import CpuProgress


class Screen(io.StringIO):
    """A standard error that is a terminal, or not."""

    def __init__(self, terminal):
        super().__init__()
        self._terminal = terminal

    def isatty(self):
        return self._terminal


@pytest.fixture
def cpu():
    return Cpu(Rack([]), lambda scan: None)


def test_the_bar_shows_the_scans_the_cpu_has_done(cpu):
    screen = io.StringIO()
    console = Console(file=screen, force_terminal=True, width=80)
    with CpuProgress(cpu, 40, console) as bar:
        cpu.run(40)
        bar.refresh()
    assert "40/40" in screen.getvalue()


@pytest.mark.parametrize(
    ("terminal", "quiet", "drawn"), [(True, False, True), (True, True, False), (False, False, False)]
)
def test_it_is_drawn_on_a_terminal_only_and_not_if_quiet(cpu, monkeypatch, terminal, quiet, drawn):
    screen = Screen(terminal)
    monkeypatch.setattr("sys.stderr", screen)
    with shown_progress(cpu, 5, quiet=quiet):
        cpu.run(5)
    assert bool(screen.getvalue()) is drawn
