"""Scenes out of a trace: what a capture of a real controller has, from each configuration to the next."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from ....traces.read.reader import Trace, open_trace
from ..moments import ImageWords, PlayedScene, SeenImage, Transmission, Window

ZERO: ImageWords = (0,) * 8


class CapturedScenes(NamedTuple):
    """What a trace has of a 3601."""

    firmware: str
    scenes: list[PlayedScene]
    notes: list[str]  # the defects of the trace


def scenes_of(path: Path, slot: int) -> CapturedScenes:
    """Return the firmware that a trace names, its scenes and its defects.

    A scan is a read of input words; output words that changed were sent between it and the next one.

    Raises:
        ValueError: it is no trace, or has no words of a 3601 in the slot.
    """
    with open_trace(path) as trace:
        info = next((each for each in trace.head.slots if each.number == slot), None)
        if info is None or info.module != "amci3601":
            raise ValueError(
                f"{path}: slot {slot} has no words of a 3601; scanrack import --as amci3601 makes them"
            )
        scenes = list(_scenes(trace, slot))
    if not scenes:
        scenes = [PlayedScene("all", note="the module is never configured, so nothing is known of its state")]
    return CapturedScenes(info.firmware or "4.1", scenes, trace.notes)


def _scenes(trace: Trace, slot: int) -> Iterator[PlayedScene]:
    scene: PlayedScene | None = None
    outputs, before_ns = ZERO, 0
    for scan in trace.scans():
        words = tuple(scan.outputs(slot))
        seen = SeenImage(Window(before_ns, scan.now_ns), tuple(scan.inputs(slot)))
        if scene is not None:
            scene.moments.append(seen)
        if words != outputs:
            if words[0] < 0 <= outputs[0]:
                if scene is not None:
                    yield scene
                scene = PlayedScene(f"configuration at {scan.now_ns / 1e9:.3f} s")
                scene.moments += [Transmission(Window(scan.now_ns, scan.now_ns), ZERO), seen]
            if scene is not None:
                scene.moments.append(Transmission(Window(scan.now_ns, scan.now_ns), words))
        outputs, before_ns = words, scan.now_ns
    if scene is not None:
        yield scene
