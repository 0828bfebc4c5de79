"""An AMCI networked drive under the 3601's command layer: link, axis, capabilities."""
