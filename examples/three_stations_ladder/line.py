"""The three-station line as rungs: configure the 3601, then continue at every pulse.

The same line as examples/three_stations, and the same images in every scan.
"""

from scanrack import Configuration, InputBit, Move, MoveKind, PresetPosition, RungMaker
from scanrack.ladder import ADD, BOOL, CLR, COP, DINT, FLL, INT, MOD, MUL, ONS, OTE, Program

CONFIGURATION = Configuration(
    inputs_used=InputBit.CAPTURE | InputBit.HOME | InputBit.CW_LIMIT | InputBit.CCW_LIMIT,
    step_and_direction=True,
    starting_speed=500,
)
MOVE = Move(MoveKind.ABSOLUTE, 0, speed=5000, acceleration=1, deceleration=1)

program = Program("line")
axis = program.slot("axis", 1)
status, outputs = axis.status, axis.O.Data
configure = program.declare("Configure", INT, 8, initial=list(CONFIGURATION.to_image()))
preset = program.declare("Preset", INT, 8, initial=list(PresetPosition(0).to_image()))
move = program.declare("Move", INT, 8, initial=list(MOVE.to_image()))
station = program.declare("Station", DINT)
pulse, pulse_before = program.declare("Pulse PulseBefore", BOOL)


@program.routine
def Main(rung: RungMaker) -> None:
    """Stations are 4000 steps apart: 4 in the thousands of the target, word 2."""
    rung([~status.MODULE_OK, status.CONFIG_ERROR], CLR(outputs[0]))
    rung("S:FS", COP(configure, outputs, 8))
    rung(status.MODE_CONFIG, ~status.CONFIG_ERROR, FLL(0, outputs, 8))
    rung(~status.MODE_CONFIG, ~status.CONFIG_ERROR, status.POSITION_INVALID, COP(preset, outputs, 8))
    rung(axis.command.PRESET_POSITION, ~status.POSITION_INVALID, FLL(0, outputs, 8))
    rung(~status.MODE_CONFIG, status.IN_CAPTURE, ONS(pulse_before), ~status.POSITION_INVALID, OTE(pulse))
    rung(pulse, ADD(station, 1, station), MOD(station, 3, station))
    rung(pulse, MUL(station, 4, move[2]), COP(move, outputs, 8))
    rung([status.MOVING_CW, status.MOVING_CCW], CLR(outputs[0]))
