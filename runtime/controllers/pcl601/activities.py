"""Activities of the axis.

kind          motion                                              ends
INDEX         a relative or absolute move                         on its last step
SLEW          endless                                             at a stop or limit
REGISTERED    a slew after its registration mark                  a number of steps after the mark
STOPPING      a slew or jog that ramps down to base speed         on the first step the ramp allows
HOME_0        to the soft limit, then at base speed               at the home limit
HOME_1        to the home limit                                   at the home limit; HOME_1_STOP follows
HOME_1_STOP   ramps down past the home limit                      like STOPPING; HOME_1_BACK follows
HOME_1_BACK   back at base speed                                  where the home limit opens
JOG           while a jog input is grounded                       when it is released
SETTLING      standstill during the encoder's delay               when the position has been checked
CORRECTION    missing steps of the encoder, at base speed         on its last step, in SETTLING
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
