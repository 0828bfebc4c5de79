"""Draw position against time of a recorded run: python picture.py TRACE PICTURE (needs scanrack[plot])."""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from scanrack.io_images.amci3601 import StatusView
from scanrack.traces.reader import open_trace

STATIONS = {0: "station 1", 4000: "station 2", 8000: "station 3"}


def draw(trace: Path, picture: Path) -> None:
    """Draw the position of slot 1, and the pulses of the stations."""
    seconds, positions, pulses = [], [], []
    with open_trace(trace) as recording:
        for scan in recording.scans():
            status = StatusView(scan.inputs(1))
            if status.MODE_CONFIG:
                continue
            seconds.append(scan.now_ns / 1e9)
            positions.append(status.position)
            if status.IN_CAPTURE:
                pulses.append((seconds[-1], positions[-1]))
    figure, axes = plt.subplots(figsize=(10, 4), constrained_layout=True)
    axes.plot(seconds, positions, color="#1f4e79", linewidth=1.8, label="current position (input words 2, 3)")
    axes.plot(
        *zip(*pulses, strict=True), "o", color="#c55a11", markersize=6, label="station done (capture input)"
    )
    axes.set_yticks(list(STATIONS), [f"{name}\n{steps:,} steps" for steps, name in STATIONS.items()])
    axes.grid(color="#d9d9d9", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.set_xlim(0, seconds[-1])
    axes.set_ylim(-800, 10_200)
    axes.set_xlabel("machine time, s")
    axes.set_title("Three-station line: a 3601 carries the part on at every pulse", loc="left")
    axes.legend(loc="upper right", ncols=2, frameon=False)
    figure.savefig(picture, dpi=110, metadata={"Software": None})


if __name__ == "__main__":
    draw(Path(sys.argv[1]), Path(sys.argv[2]))
