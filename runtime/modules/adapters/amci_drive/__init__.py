"""A networked drive of AMCI under the 3601's command layer: its link, its axis, its capabilities."""
