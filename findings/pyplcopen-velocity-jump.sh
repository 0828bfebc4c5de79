#!/usr/bin/env bash
# what: pyplcopen's move_velocity is at full speed in its first cycle and reverses in one, whatever acceleration and jerk say
# date: 2026-11-30
# meets: anyone who tests a jogging axis or a stepper's start speed in that simulation
# expected: changes of at most 0.01 per cycle, 50 cycles or more to 0.5, as move_absolute and halt make them
# behavior:
#   The speed steps from 0 to 0.5 and from 0.5 to -0.5 between two cycles, the command acceleration is 0 all the time, and
#   the simulated drive follows at once. move_absolute and halt with the same limits ramp.
# product: An axis ramps from its starting speed in runs as in moves, with the command's acceleration: [the axis](axis.md#commands)
# output:
#   move_absolute to 30: speeds up to 0.5, largest change 0.01
#   halt from 0.5: stops after 15.0 more
#   move_velocity 0.5: speed 0.5 at position 0.5 after one cycle, command acceleration 0.0
#   move_velocity -0.5: speed -0.5 after one cycle, 1.0 less than before
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install pyplcopen==0.21.0
observe python - <<'PY'
from itertools import pairwise

from pyplcopen import AxisSim

SPEED = 0.5
LIMITS = {"acceleration": 0.01, "deceleration": 0.01, "jerk": 0.001}


def powered():
    axis = AxisSim()
    axis.power_on()
    return axis


axis = powered()
speeds = [0.0]
try:
    axis.move_absolute(30, SPEED, **LIMITS, max_cycles=1)
except RuntimeError:  # not there after one cycle: it goes on
    pass
while abs(axis.command_position() - 30) > 1e-9 and len(speeds) < 1000:
    speeds.append(axis.command_velocity())
    axis.cycle()
change = max(abs(later - earlier) for earlier, later in pairwise(speeds))
print(f"move_absolute to 30: speeds up to {max(speeds):.2g}, largest change {change:.2g}")

axis = powered()
axis.move_velocity(SPEED, **LIMITS)
first = axis.command_velocity(), axis.command_position(), axis.command_acceleration()
position = axis.command_position()
axis.halt(LIMITS["deceleration"], LIMITS["jerk"])
print(f"halt from {SPEED}: stops after {axis.command_position() - position:.1f} more")
print("move_velocity {}: speed {} at position {} after one cycle, command acceleration {}".format(SPEED, *first))

axis = powered()
axis.move_velocity(SPEED, **LIMITS)
axis.move_velocity(-SPEED, **LIMITS)
speed = axis.command_velocity()
print(f"move_velocity {-SPEED}: speed {speed} after one cycle, {first[0] - speed} less than before")
PY
