"""The five programs on a PCL601 or a PMC006x3s: the same sequences, with what these controllers need.

Each axis waits for an answer for longer than a configuration takes. On a PMC006 the home switch is the CCW
limit, too, so nothing may end on it.
"""

import blend_path
import jog_panel
import labeller
import shared_zone
import stations
from scanrack import Axis3601

ROUND_TRIP_MS = 400
OFF_THE_SWITCH = 100  # steps


def patient(axis: Axis3601) -> Axis3601:
    """Return an axis that waits long enough for the answer of a controller behind an adapter."""
    return Axis3601(axis.slot, axis.configuration, round_trip_ms=ROUND_TRIP_MS)


class Stations(stations.Stations):
    """Three stations on a PCL601."""

    axis = patient(stations.Stations.axis)


class StationsOffTheSwitch(Stations):
    """Three stations on a PMC006x3s."""

    stations = (OFF_THE_SWITCH, 4000, 8000)


class Labeller(labeller.Labeller):
    """The labeller on either controller; both stop at the mark before they go on."""

    web = patient(labeller.Labeller.web)
    limit = "3 s"


class BlendPath(blend_path.BlendPath):
    """The path on either controller; both stop between its segments."""

    axis = patient(blend_path.BlendPath.axis)


class Panel(jog_panel.Panel):
    """The jog panel on either controller."""

    axis = patient(jog_panel.Panel.axis)


class Pair(shared_zone.Pair):
    """The shared zone on PCL601s."""

    feeder = patient(shared_zone.Pair.feeder)
    pusher = patient(shared_zone.Pair.pusher)


class PairOffTheSwitches(Pair):
    """The shared zone on PMC006x3s."""

    home = OFF_THE_SWITCH
