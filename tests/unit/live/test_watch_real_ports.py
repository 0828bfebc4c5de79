"""`scanrack watch --live`: a PCL601 in another process, on TCP, and what a page may do to it.

Broken on purpose: orders taken without --control, a pause, an edit without --control: a test turns red.
"""

import asyncio
import subprocess
import sys

import forked
import pytest
from scanrack.commands import build
from scanrack.io_images.amci3601 import status_names
from typer.testing import CliRunner
from watching import page_of, watched

PROGRAM = "def logic(scan):\n    pass\n"
RACK = """\
program = "still.py"
scan_ms = 2
[[slot]]
number = 1
module = "pcl601-adapter"
port = "{}"
"""
WAITS: list[tuple[str, dict[str, object]]] = [
    ("pause", {}),
    ("step", {"scans": 3}),
    ("speed", {"factor": 2}),
    ("breakpoint", {"at": "Main.0"}),
    ("branch", {"scan": 1}),
]


@pytest.fixture
def rack(tmp_path):
    """A rack file whose module is on the port of a PCL601 in a process of its own."""
    words = [sys.executable, "-m", "scanrack", "serve", "pcl601", "--tcp", "0", "--rtu-over-tcp", "--quiet"]
    process = forked.start(words, stdout=subprocess.PIPE, text=True, encoding="utf-8")
    try:
        assert process.stdout is not None
        place = process.stdout.readline().split("  ")[0]
        (tmp_path / "still.py").write_text(PROGRAM, encoding="utf-8")
        path = tmp_path / "rack.toml"
        path.write_text(RACK.format(f"tcp:{place}"), encoding="utf-8")
        yield path
    finally:
        process.kill()
        process.communicate()


def bits_of(page):
    msw, lsw = page.frame["words"]["1"][:2]
    return set(status_names(msw & 0xFFFF, lsw & 0xFFFF))


async def until_bit(page, name, *, on=True):
    await page.until(lambda seen: "words" in seen.frame and (name in bits_of(seen)) is on)


async def give(page, command, *parameters):
    """Force all output words: no command, the parameters, then the command, which begins with its bit."""
    words = [*parameters, *[0] * (7 - len(parameters))]
    for place, word in [(0, 0), *enumerate(words, 1), (0, command)]:
        answer = await page.ask("force", tag=f"Local:1:O.Data[{place}]", value=word)
        assert "refused" not in answer, answer


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ([], "moves a real motor"),
        (["--allow-writes"], "moves a real motor"),
        (["--live", "--paused"], "no --paused and no --time-scale"),
        (["--live", "--time-scale", "2"], "no --paused and no --time-scale"),
    ],
)
def test_what_a_real_controller_does_not_do_is_refused_before_the_port_is_opened(tmp_path, options, says):
    (tmp_path / "still.py").write_text(PROGRAM, encoding="utf-8")
    rack = tmp_path / "rack.toml"
    rack.write_text(RACK.format("/dev/nothing-here"), encoding="utf-8")
    done = CliRunner().invoke(build(), ["watch", str(rack), *options])
    assert done.exit_code == 2
    assert says in " ".join(done.stderr.split())


def test_a_port_that_cannot_be_opened_ends_the_command_with_its_reason(tmp_path):
    (tmp_path / "still.py").write_text(PROGRAM, encoding="utf-8")
    rack = tmp_path / "rack.toml"
    rack.write_text(RACK.format("/dev/nothing-here"), encoding="utf-8")
    done = CliRunner().invoke(build(), ["watch", str(rack), "--live"])
    assert done.exit_code == 2
    assert "/dev/nothing-here can't be opened" in " ".join(done.stderr.split())


@pytest.mark.slow
def test_without_control_a_page_looks_and_changes_nothing(rack):
    async def look(session):
        async with page_of(session) as page:
            await until_bit(page, "MODULE_OK")
            hello = page.hello
            refused = [await page.ask(order, **fields) for order, fields in WAITS]
            refused.append(await page.ask("force", tag="Local:1:O.Data[0]", value=2))
            (rack.parent / "still.py").write_text(PROGRAM + "\n# saved\n", encoding="utf-8")
            begun = page.frame["scan"]
            await page.until(lambda seen: seen.frame["scan"] > begun + 500)  # a second: three looks at a file
            assert not [each for each in page.frame["events"] if each["kind"] == "edit"]
            return hello, [each["refused"] for each in refused]

    with watched("--live", rack=rack) as session:
        hello, refused = asyncio.run(look(session))
        assert session.end() == 130
    assert (hello["read_only"], hello["live_ports"], hello["branches"]) == (True, True, False)
    assert hello["incidents"] == []
    assert set(refused) == {"this session is read-only: it accepts no actions"}


@pytest.mark.slow
def test_with_control_a_page_moves_the_axis_and_time_goes_on(rack):
    """2000 steps at 5000 steps/s, from a position that was made valid at 0."""

    async def work(session):
        async with page_of(session) as page:
            await until_bit(page, "MODULE_OK")
            refused = [(await page.ask(order, **fields))["refused"] for order, fields in WAITS]
            await give(page, 0x843C, 63, 1, 0)
            await until_bit(page, "CONFIG_ERROR", on=False)
            await give(page, 0)
            await until_bit(page, "MODULE_OK")
            await give(page, 512)
            await until_bit(page, "POSITION_INVALID", on=False)
            await give(page, 0)
            await give(page, 2, 0, 2, 0, 5, 0, 50, 50)
            await until_bit(page, "MOVE_COMPLETE")
            await page.until(lambda seen: seen.frame["values"]["1"]["position"] == 2000)
            (rack.parent / "still.py").write_text(PROGRAM + "\n# saved\n", encoding="utf-8")
            while "edited" not in await page.hear():
                pass
            return refused

    record = rack.parent / "session.mcap"
    with watched("--live", "--allow-writes", "--record", record, rack=rack) as session:
        refused = asyncio.run(work(session))
        assert session.end() == 130
    assert all("a real controller does not wait" in each for each in refused), refused
    done = CliRunner().invoke(build(), ["replay", "--into", "session", str(record), "--trust"])
    assert done.exit_code == 2
    assert " is real, " in done.stderr


@pytest.mark.slow
def test_a_branch_of_a_recording_of_real_ports_is_refused(rack):
    record = rack.parent / "session.mcap"

    async def branch(session):
        async with page_of(session) as page:
            await page.until(lambda seen: "scan" in seen.frame)
            return [await page.ask("branch", scan=10), await page.ask("look", scan=5)]

    with watched("--live", "--record", record, "--scans", "300", rack=rack) as session:
        assert session.process.wait(120) == 0
    with watched("--trust", rack=record) as session:
        refused, looked = asyncio.run(branch(session))
    assert " is real, " in refused["refused"]
    assert looked["scan"] == 5
