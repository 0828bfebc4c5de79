"""What stops a program from outside names task, routine and rung or line, in both back ends."""

import pytest
from scanrack.ladder import Controller
from scanrack.ladder.files import parse_program
from scanrack.runtime import Cpu, CpuFault, Rack
from scanrack.runtime.loop.pace import WatchdogTimeout

RUNGS = """CONTROLLER plant
TAG Go : BOOL
TASK Cycle : CONTINUOUS RUNS Main

PROGRAM Main
ROUTINE First
XIC(Go)OTE(Go);
JSR(Second);
END

ROUTINE Second
NOP();
NOP();
XIO(Go)JSR(Stop);
END
END PROGRAM
"""
TEXT = """CONTROLLER plant
TAG Count : DINT
TASK Cycle : CONTINUOUS RUNS Main

PROGRAM Main
ROUTINE Fill ST
Count := 1;
IF Count = 1 THEN
    JSR(Stop);
END_IF;
END
END PROGRAM
"""


class Stop(BaseException):
    """Stops a program, as the watchdog's or Ctrl-C does."""


def made(text, error):
    """Return a controller whose routine `Stop` in Python raises an error."""
    controller = parse_program(text)

    def stop(_tags):
        raise error

    stop.__name__ = "Stop"
    assert isinstance(controller, Controller)
    controller.programs[0].function(stop)
    return controller


@pytest.mark.parametrize("back_end", ["compile", "interpret"])
@pytest.mark.parametrize(
    ("text", "place"),
    [(RUNGS, r"task Cycle, routine \Main.Second, rung 2"), (TEXT, r"task Cycle, routine \Main.Fill, line 3")],
)
def test_the_error_gets_a_note_of_the_place(text, place, back_end):
    engine = getattr(made(text, Stop()), back_end)()
    with pytest.raises(Stop) as caught:
        engine.step()
    assert caught.value.__notes__ == [place]


def test_the_watchdog_says_where_the_program_was():
    controller = made(RUNGS, WatchdogTimeout("it took longer than 500 ms of processor time"))
    with pytest.raises(CpuFault) as caught:
        Cpu(Rack({}), controller).run(1)
    assert caught.value.fault.text == (
        r"it took longer than 500 ms of processor time, task Cycle, routine \Main.Second, rung 2"
    )


def test_a_program_is_compiled_before_its_first_scan():
    """That takes long for a large one, and its first scan has the watchdog's limit as any other."""
    controller = made(RUNGS, Stop())
    Cpu(Rack({}), controller)
    assert controller._engine is not None
