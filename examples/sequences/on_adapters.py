"""Programs for a PCL601 or a PMC006x3s: the same sequences, with what these controllers need.

On a PMC006 the home switch is the CCW limit, too, so nothing may end on it. Both stop at a mark before they
go on, so a label takes longer.
"""

import labeller
import shared_zone
import stations

OFF_THE_SWITCH = 100  # steps


class StationsOffTheSwitch(stations.Stations):
    """Three stations on a PMC006x3s."""

    stations = (OFF_THE_SWITCH, 4000, 8000)


class Labeller(labeller.Labeller):
    """The labeller on either controller."""

    limit = "3 s"


class PairOffTheSwitches(shared_zone.Pair):
    """The shared zone on PMC006x3s."""

    home = OFF_THE_SWITCH
