"""Part 1 of the tutorial, sentence by sentence: what a reader clicks, and what the machine then does."""

import re

from watched_page import until, watching

from .conftest import FEEDER

PANEL = FEEDER.parent / "three_stations_panel" / "line.toml"
PLACE = "return document.querySelector('svg.rail .{}').getAttribute('transform')"
