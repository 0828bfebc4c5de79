"""What an editor and a type checker know of a sequence: mypy checks each `assert_type` of this program."""

from typing import assert_type

from bench3601 import configuration
from scanrack import (
    Axis3601,
    Configuration,
    Input,
    InputWord,
    Logic,
    Output,
    all_of,
    dwell,
    first_of,
    sequence,
    until,
    within,
)
from scanrack.io_images.amci3601 import InputBit
from scanrack.io_images.image import Image
from sequence_bench import SequenceBench


class Typed(Logic):
    axis = Axis3601(1, Configuration.from_image(Image(configuration(add=1))))
    start = Input("start")
    level = InputWord("Local:2:I.Data[1]")
    lamp: Output = Output("Local:2:O.Data.0")
    winner = ""

    @sequence
    async def cycle(self) -> None:
        await self.axis.configure()
        assert_type(await self.where(), str)
        pair = await all_of(self.where(), self.axis.captured())
        assert_type(pair, tuple[str, int])
        assert_type(await all_of(self.where(), self.where(), dwell("2 ms")), tuple[str, str, None])
        assert_type(await within("5 s", self.where()), str)
        run = self.axis.run(2_000, acceleration=20, deceleration=20)
        assert_type(run.in_velocity, bool)
        registration = self.axis.run(2_000, register=500, acceleration=20, deceleration=20)
        registration.register()
        pause = dwell("10 ms")
        first = await first_of(registration, pause)
        self.winner = "pause" if first is pause else "registration"
        with self.axis.stop() as stop:
            await stop
        self.lamp = self.level > 0
        assert_type(self.lamp, bool)
        assert_type(self.level, int)
        self.other.restart()

    @sequence(start=False)
    async def other(self) -> None:
        self.winner += ", other"

    async def where(self) -> str:
        await until(lambda: True)
        return "here"


def test_the_program_runs():
    bench = SequenceBench(Typed).scan(50)
    bench.module.machine.set_input(InputBit.CAPTURE, True)
    bench.module.look_again()
    bench.card.inputs[1] = 7
    bench.until(lambda: bench.logic.winner.endswith("other"))
    assert (bench.logic.winner, bench.lamp(0)) == ("pause, other", True)
