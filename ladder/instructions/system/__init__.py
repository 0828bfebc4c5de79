"""The controller itself: GSV and SSV, messages, ports, phases, immediate outputs."""
