"""Activities of the axis.

kind          motion                                              ends
INDEX         makes a relative or absolute move                   on its last step
SLEW          moves until it is stopped                           at a stop or limit
REGISTERED    continues a slew after its registration mark        a number of steps after the mark
STOPPING      ramps a slew or jog down to base speed              on the first step the ramp allows
HOME_0        moves to the soft limit, then at base speed         at the home limit
HOME_1        moves to the home limit                             at the home limit; HOME_1_STOP follows
HOME_1_STOP   ramps down past the home limit                      like STOPPING; HOME_1_BACK follows
HOME_1_BACK   moves back at base speed                            where the home limit opens
JOG           moves while a jog input is grounded                 when the input is released
SETTLING      rests during the encoder's delay                    when the position has been checked
CORRECTION    makes the steps that the encoder has not counted,   on its last step; SETTLING follows
              at base speed
"""

from __future__ import annotations

from enum import Enum, auto


class AxisActivity(Enum):
    """An activity of the axis; see the table above."""

    INDEX = auto()
    SLEW = auto()
    REGISTERED = auto()
    STOPPING = auto()
    HOME_0 = auto()
    HOME_1 = auto()
    HOME_1_STOP = auto()
    HOME_1_BACK = auto()
    JOG = auto()
    SETTLING = auto()
    CORRECTION = auto()


HOMING = frozenset(
    {AxisActivity.HOME_0, AxisActivity.HOME_1, AxisActivity.HOME_1_STOP, AxisActivity.HOME_1_BACK}
)
SLOWED_ONCE = frozenset(
    {AxisActivity.INDEX, AxisActivity.REGISTERED, AxisActivity.SLEW, AxisActivity.HOME_0, AxisActivity.HOME_1}
)
"""Activities that a soft limit or a soft stop slows down."""
