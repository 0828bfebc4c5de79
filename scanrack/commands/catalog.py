"""The commands by name, with their lines in `scanrack --help` and the modules of their options."""

from __future__ import annotations

from typing import NamedTuple


class Entry(NamedTuple):
    """A line of `scanrack --help`."""

    module: str  # module of the command, relative to this package, with a function `register(app)`
    sentence: str


GROUPS = {
    "Run and watch": {
        "new": Entry(".programs.new", "Create a project."),
        "run": Entry(".programs.run", "Run a rack and record every scan."),
        "watch": Entry("..watch.command", "Open a live rack or a trace in the browser."),
        "debug": Entry("..dap.command", "Debug a rack or a trace in an editor."),
    },
    "Traces": {
        "show": Entry(".recordings.show", "List events and changes."),
        "query": Entry(".recordings.query", "Find scans matching a condition."),
        "plot": Entry(".recordings.plot", "Draw a timing chart."),
        "compare": Entry(".recordings.compare", "Find where two traces differ."),
        "replay": Entry(".recordings.replay", "Replay and check for differences."),
        "share": Entry("..watch.share.command", "Export as one HTML file."),
        "export": Entry(".recordings.export", "Convert a trace for other programs."),
        "import": Entry(".recordings.imports", "Convert a network capture."),
        "repair": Entry(".recordings.repair", "Recover a damaged trace."),
    },
    "Programs": {
        "check": Entry(".programs.check", "Check a rack or program without running it."),
        "why": Entry(".programs.why", "Explain why a tag has its value."),
        "ladder": Entry(".programs.ladder", "Draw rungs."),
        "xref": Entry(".programs.why", "List where tags are read and written."),
        "tags": Entry(".programs.tags", "List the tags that clients of --server see."),
        "l5x": Entry(".programs.l5x", "Report what an L5X or SLC export supports."),
    },
    "Search and prove": {
        "fuzz": Entry(".programs.fuzz", "Search for inputs and faults that break a program."),
        "prove": Entry(".programs.prove", "Prove properties or find counterexamples."),
    },
    "Devices and hardware": {
        "device": Entry(".wire.device", "List, identify, read, set and move devices."),
        "serve": Entry(".wire.serve", "Simulate a device on a port."),
        "drive": Entry(".wire.drive", "Exercise one module with JSON requests."),
        "conform": Entry(".wire.conform", "Test a real 3601 against its manual."),
    },
    "Setup and reference": {
        "doctor": Entry(".programs.doctor", "Check this installation."),
        "editor": Entry(".programs.editor", "Connect an editor."),
        "rules": Entry(".programs.rules", "List rules and error bits of a 3601 or a drive."),
    },
}
"""The commands by heading, in the order of --help."""

COMMANDS = {name: entry for group in GROUPS.values() for name, entry in group.items()}
