"""A PMC006x3s under the 3601's command layer: link, axis, capabilities."""
