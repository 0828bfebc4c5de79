"""Since when a tag, a bit, a word or a value is as it is, and what it was before.

Broken on purpose: the scan before the change, the value after it: a test turns red.
"""

import asyncio

import pytest
from scanrack.jobs import open_bench
from watching import FEEDER, page_of, watched

pytestmark = pytest.mark.slow

SCANS = 3000


def changes(read):
    """Return the last change of a value in the first scans, as a bench shows it: scan, value before."""
    bench = open_bench(FEEDER)
    bench.scan()
    found, before = None, read(bench)
    for scan in range(1, SCANS):
        bench.scan()
        value = read(bench)
        if value != before:
            found, before = (scan, before), value
    return found


READS = {
    "Strokes.ACC": lambda bench: bench["Strokes.ACC"],
    "Axis.State": lambda bench: bench["Axis.State"],
    "Local:1:I.Data[0].0": lambda bench: bool(bench.slot[1].inputs[0] & 1),  # MOVING_CW
    "Local:1:O.Data[0]": lambda bench: bench.slot[1].outputs[0],
}


@pytest.fixture(scope="module")
def wanted():
    return {name: changes(read) for name, read in READS.items()}


def test_tags_bits_and_words_say_since_when(wanted):
    async def ask(session):
        async with page_of(session) as page:
            await page.ask("step", scans=SCANS)
            await page.until(lambda seen: seen.frame.get("scan") == SCANS - 1)
            found = {name: (await page.ask("since", tag=name))["since"] for name in READS}
            await page.ask("look", scan=found["Axis.State"]["scan"] - 1)
            return (
                found,
                (await page.ask("since", tag="Axis.State"))["since"],
                await page.ask("since", tag="No"),
            )

    with watched("--paused", "--time-scale", "max") as session:
        found, earlier, none = asyncio.run(ask(session))
    assert {name: (each["scan"], each["before"]) for name, each in found.items()} == wanted
    assert found["Axis.State"]["t"] == found["Axis.State"]["scan"] * 2_000_000
    assert earlier["scan"] < found["Axis.State"]["scan"]
    assert none["since"] is None


def test_values_of_python_say_since_when(tmp_path):
    (tmp_path / "rack.toml").write_text(
        'program = "steps.py"\nscan_ms = 2\ntags = ["state.step"]\n'
        '[[slot]]\nnumber = 1\nmodule = "1769-IQ16"\n',
        encoding="utf-8",
    )
    (tmp_path / "steps.py").write_text(
        "class State:\n    step: int = 0\n    other: int = 0\n\n\nstate = State()\n\n\n"
        "def logic(scan):\n    state.step = scan.number // 100\n",
        encoding="utf-8",
    )

    async def ask(session):
        async with page_of(session) as page:
            for scans, step in ((150, 1), (100, 2)):  # in a pause all values are there
                await page.ask("step", scans=scans)
                await page.until(lambda seen, step=step: seen.frame.get("tags", {}).get("state.step") == step)
            found = [(await page.ask("since", tag=f"state.{name}"))["since"] for name in ("step", "other")]
            return found[0]["scan"], found[0]["before"], found[1]

    with watched("--paused", "--time-scale", "max", rack=tmp_path / "rack.toml") as session:
        scan, before, other = asyncio.run(ask(session))
    assert before == 1
    assert 200 <= scan <= 249  # recorded it is 200; else when it was read
    assert other is None
