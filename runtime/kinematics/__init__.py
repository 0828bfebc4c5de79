"""Kinematics: motions as closed forms of time, exact in integers.

`move`, `run`, `single_step` and `blend` plan a motion. `stop`, `change_speed`, `register`, `go_on` and
`creep` plan the rest of a motion from an instant on. A plan never changes: queries return its position at an
instant, or the instant of a step.

Time is in ns, travel in 1e-12 step, speed in 1e-3 step/s, all integers; step counts are whole.
"""

from .blend import BlendLeg, blend, check_blend
from .course import Course, Phase
from .motion import Motion
from .plans import change_speed, creep, go_on, move, register, run, single_step, stop, takeover
from .profile import Profile
from .segment import FOREVER, Cruise, Quadratic, Segment
from .shape import (
    MILLI,
    NANO,
    PICO,
    AnyShape,
    Jerk,
    Rate,
    Shape,
    ramp_distance,
    ramp_time,
    stopping_distance,
)

__all__ = [
    "FOREVER",
    "MILLI",
    "NANO",
    "PICO",
    "AnyShape",
    "BlendLeg",
    "Course",
    "Cruise",
    "Jerk",
    "Motion",
    "Phase",
    "Profile",
    "Quadratic",
    "Rate",
    "Segment",
    "Shape",
    "blend",
    "change_speed",
    "check_blend",
    "creep",
    "go_on",
    "move",
    "ramp_distance",
    "ramp_time",
    "register",
    "run",
    "single_step",
    "stop",
    "stopping_distance",
    "takeover",
]
