"""The axis over any module with a 3601's words: the feeder as a sequence, on three hardwares.

The story is that of `tests/unit/adapters/test_feeder_on_three_hardwares.py`, whose program is made of rungs:
home, two strokes back and forth, an emergency stop in the third, home again. As docs/adapters.md asks,
strokes end 100 steps off the home switch. An axis takes the round trip of an adapter, 400 ms, from the rack;
on the 3601 the program asks for the same, so that the emergency stop meets the same stroke.
"""

from pathlib import Path

import pytest
from feeder_story import HARDWARES, STORY, moves_of
from scanrack.jobs import build_cpu, build_rack, load_job
from scanrack.jobs.load.loading import load_spec
from witness import Witness

FEEDER = Path(__file__).parents[3] / "examples" / "feeder" / "feeder.toml"
SCANS = 10_000  # 20 s

PROGRAM = """\
from scanrack import Axis3601, AxisError, Configuration, Direction, Logic, State, sequence, steady


class Feeder(Logic):
    setup = Configuration(inputs_used=0x3C, active_high=0x3C, step_and_direction=True, starting_speed=500)
    axis = Axis3601(1, setup, OPTIONS)

    @sequence
    async def cycle(self):
        await self.axis.configure()
        while True:
            try:
                if self.axis.state == State.ERROR_STOP:
                    await self.axis.reset()
                if self.axis.status.POSITION_INVALID:
                    await self.axis.home(Direction.CCW, speed=2000, acceleration=10, deceleration=10)
                while True:
                    await self.axis.move_to(6000, speed=4000, acceleration=10, deceleration=10)
                    await self.axis.move_to(100, speed=8000, acceleration=10, deceleration=10)
            except AxisError:
                await steady(lambda: not self.axis.status.IN_ESTOP, "1 s")
"""


AS_SLOW = {"amci3601": "round_trip_ms=400, "}


def run(folder, hardware, options=""):
    """Run the feeder; return its moves."""
    options = AS_SLOW.get(hardware, "") + options
    (folder / "feeder.py").write_text(PROGRAM.replace("OPTIONS", options), encoding="utf-8")
    text = FEEDER.read_text(encoding="utf-8")
    for right, instead in {
        "feeder.rung": "feeder.py",
        '"amci3601"': f'"{hardware}"',
        'firmware = "4.1"': HARDWARES[hardware],
        "at_s = 8.0": "at_s = 12.0",
    }.items():
        assert right in text
        text = text.replace(right, instead)
    (folder / "rack.toml").write_text(text, encoding="utf-8")
    job = load_job(str(folder / "rack.toml"))
    witness = Witness()
    with build_cpu(job.spec, job.logic, build_rack(job.spec), listeners=[witness]) as cpu:
        cpu.run(SCANS)
    return moves_of(witness)


@pytest.mark.slow
@pytest.mark.parametrize("hardware", HARDWARES)
def test_a_sequence_makes_the_same_moves(hardware, tmp_path):
    assert run(tmp_path, hardware)[: len(STORY)] == STORY


@pytest.mark.slow
@pytest.mark.parametrize("hardware", HARDWARES)
def test_parameters_first_on_each_of_them(hardware, tmp_path):
    moves = run(tmp_path, hardware, "parameters_first=True")
    assert moves[:4] == STORY[:4]


RACK = """
program = "none.py"
controller = "CONTROLLER"
scan_ms = 2
[[slot]]
number = 1
module = "MODULE"
"""


@pytest.mark.parametrize(
    ("controller", "module", "trip_ms"),
    [
        ("micrologix", "amci3601", 0),
        ("compactlogix", "amci3601", 20 + 20 + 2),
        ("micrologix", "pcl601-adapter", 400),
        ("compactlogix", "pmc006-adapter", 400 + 20 + 20 + 2),
    ],
)
def test_a_rack_knows_the_round_trip_of_each_slot(controller, module, trip_ms, tmp_path):
    rack = tmp_path / "rack.toml"
    interval = "rpi_ms = 20\n" * (controller == "compactlogix")
    rack.write_text(
        interval + RACK.replace("CONTROLLER", controller).replace("MODULE", module), encoding="utf-8"
    )
    assert build_rack(load_spec(str(rack))[0]).slots[1].round_trip_ms == trip_ms
