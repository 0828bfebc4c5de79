"""An AMCI networked drive operated by the 3601's command layer: link, axis, capabilities."""
