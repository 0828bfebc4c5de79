"""A PMC006x3s under the 3601's command layer: its link, its axis, its capabilities."""
