"""Kinematics: motions as closed forms of time, exact in integers.

A motion is planned once (`move`, `run`, `single_step`, `blend`) and changed by
planning anew from an instant of it (`stop`, `change_speed`, `register`,
`go_on`, `creep`). In between it is only evaluated: where it is at an instant,
at which instant it makes a step. Nothing advances, so nothing depends on how
often it is asked.

Time is in ns, travel in 1e-12 step, speed in 1e-3 step/s, all integers; steps
are whole ones.
"""

from .blend import BlendLeg, blend, check_blend
from .course import Course, Phase
from .motion import Motion
from .plans import change_speed, creep, go_on, move, register, run, single_step, stop, takeover
from .profile import Profile
from .segment import FOREVER, Cruise, Quadratic, Segment
from .shape import MILLI, NANO, PICO, Rate, Shape, ramp_distance, ramp_time_ns, stopping_distance

__all__ = [
    "FOREVER",
    "MILLI",
    "NANO",
    "PICO",
    "BlendLeg",
    "Course",
    "Cruise",
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
    "ramp_time_ns",
    "register",
    "run",
    "single_step",
    "stop",
    "stopping_distance",
    "takeover",
]
