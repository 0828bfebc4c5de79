"""A controller, a rack, a run, its result and its recording: all from the front door.

Run it in this folder: python first.py
"""

from pathlib import Path

from scanrack import (
    BOOL,
    OTE,
    TIMER,
    TON,
    XIC,
    Controller,
    RungMaker,
    RunResult,
    Scan,
    load_rack,
    open_trace,
    run,
)

plant = Controller("plant")
start = plant.declare("Start", BOOL, initial=True)
late = plant.declare("Late", BOOL)
delay = plant.declare("Delay", TIMER)
main = plant.program("Main")


@main.routine
def Main(rung: RungMaker) -> None:
    rung(XIC(start), TON(delay, 20))
    rung(XIC(delay.DN), OTE(late))


if __name__ == "__main__":
    result: RunResult = run(load_rack("rack.toml", plant), "100 ms", trace="first.mcap")
    with open_trace(Path("first.mcap")) as trace:
        scans: list[Scan] = list(trace.scans())
    print(f"{result.scans} scans, {len(result.moves)} moves, the last scan at {scans[-1].now_ns} ns")
    print(f"Late is {plant.tags.Late}")
    for error in result.errors + result.every_start:
        print(error.text)
