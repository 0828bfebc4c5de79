"""Does `scanrack conform` tell what differs, and nothing else?

    python benchmarks/conform.py [--runs N] [--plan NAME] [--scene NAME] [--without-counter] [--smoke]

A rack with a simulated 3601 runs in a process of its own, `scanrack run --realtime --server ethernet-ip`; the
plan is played through its tags with pycomm3. N runs of an unchanged module must show no difference. Then the
module deviates in ten ways, one at a time; the scenes that may show it are played. At least eight have to be
told, and none may end with all scenes as the manual. Then its planner of moves is off by a factor, three
times: the told value has to have it within its uncertainty. `--smoke` plays one scene without a socket,
unchanged and with one deviation.

Exit status 1 if a bar is missed.
"""

from __future__ import annotations

import argparse
import socket
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, closing, contextmanager, nullcontext
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from time import monotonic, perf_counter
from typing import NamedTuple
from unittest import mock

from scanrack.jobs.conform.findings import ConformVerdict
from scanrack.jobs.conform.hypotheses import search
from scanrack.jobs.conform.moments import PlayedScene
from scanrack.jobs.conform.paths.logix_path import LogixPath, ModuleTags, connect
from scanrack.jobs.conform.plan import ScenePlan, load_plan
from scanrack.jobs.conform.playing import play
from scanrack.jobs.conform.report import fitted_scales
from scanrack.jobs.conform.rules_apart.rivals import RIVALS
from scanrack.jobs.conform.rules_apart.without import STATEMENTS
from scanrack.jobs.conform.verdicts import Judge
from scanrack.runtime.kinematics import Motion, Profile
from scanrack.runtime.modules.amci3601 import module, step_generator
from scanrack.runtime.modules.amci3601.altered import Alteration, Altered3601, ImageWords
from scanrack.runtime.modules.amci3601.module import Amci3601

SCAN_NS = 2_000_000
RACK = """name = "blank"
program = "blank.rung"
scan_ms = 2
trace = "blank.mcap"
keep_traces = 0

[server]
writable = ["Local:1:O.Data"]

[[slot]]
number = 1
module = "amci3601"
firmware = "4.1"
"""
PROGRAM = "PROGRAM blank\nTAG Scan : DINT\nROUTINE Main\nADD(Scan,1,Scan);\nEND\n"


def _weaker(words: ImageWords) -> ImageWords:
    moves = words[0] > 0 and words[6] > 1
    return (*words[:6], words[6] - 1, words[7]) if moves else words


def _slower(words: ImageWords) -> ImageWords:
    speed = words[4] * 1000 + words[5]
    if words[0] <= 0 or speed < 1000:
        return words
    return (*words[:4], *divmod(speed - speed // 50, 1000), *words[6:])


class Deviation(NamedTuple):
    """A deviation, and the scenes that are played with it."""

    alteration: Alteration
    scenes: tuple[str, ...]


MOVES = ("relative moves", "a longer move", "immediate stop")
DEVIATIONS: Mapping[str, Deviation] = {
    "A-02": Deviation(RIVALS["A-02"][0], ("bits over a configuration", "relative moves")),
    "A-27": Deviation(RIVALS["A-27"][0], ("an error during a move", "relative moves")),
    "A-102": Deviation(RIVALS["A-102"][0], ("bits over a configuration", "immediate stop")),
    "A-82": Deviation(RIVALS["A-82"][0], ("presets and absolute moves", "relative moves")),
    "A-20": Deviation(RIVALS["A-20"][0], ("parameters out of range", "relative moves")),
    "acceleration - 1": Deviation(Alteration("It accelerates less.", hears=_weaker), MOVES),
    "speed - 2 %": Deviation(Alteration("It is slower.", hears=_slower), MOVES),
    "Stopped missing": Deviation(STATEMENTS["STS-M03"], MOVES),
    "Hold State stays": Deviation(STATEMENTS["HLD-12"], ("hold and resume", "relative moves")),
    "stop leaves valid": Deviation(STATEMENTS["IST-02"], MOVES),
}


FACTORS: Mapping[str, tuple[str, float]] = {
    "acceleration 0.93": ("acceleration", 0.93),
    "acceleration 1.05": ("acceleration", 1.05),
    "speed 0.98": ("speed", 0.98),
}
"""Factors of the module's planner, and what they are told as."""


def off_by(factor: tuple[str, float] | None) -> AbstractContextManager[object]:
    """Let the planner of moves be off by a factor."""
    if factor is None:
        return nullcontext()
    what, value = factor
    right = step_generator.plan_move

    def plan(now_ns: int, origin: int, distance: int, profile: Profile) -> Motion:
        if what == "speed":
            profile = replace(profile, speed_sps=round(profile.speed_sps * value))
        else:
            rate = Fraction(str(value)) * profile.acceleration_spmss
            profile = replace(profile, acceleration_spmss=rate)
        return right(now_ns, origin, distance, profile)

    return mock.patch.object(step_generator, "plan_move", plan)


def serve(rack: str, port: int, deviation: str) -> None:
    """Run a rack with a module that deviates; it ends when it is terminated."""
    from scanrack.commands import main

    alteration = DEVIATIONS[deviation].alteration if deviation in DEVIATIONS else None

    def made(firmware: str, *_given: object, **_named: object) -> Amci3601:
        assert alteration is not None
        return Altered3601(alteration, firmware)

    sys.argv = ["scanrack", "run", rack, "--realtime", "--server", f"ethernet-ip:{port}", "-q", "--no-record"]
    planner = off_by(FACTORS.get(deviation))
    with mock.patch.object(module, "Amci3601", made if alteration else Amci3601), planner:
        main()


@contextmanager
def served(deviation: str) -> Iterator[int]:
    """Serve a rack from a process of its own; yield the port once it answers."""
    with tempfile.TemporaryDirectory() as folder, socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
        free.close()
        Path(folder, "blank.toml").write_text(RACK, "utf-8")
        Path(folder, "blank.rung").write_text(PROGRAM, "utf-8")
        words = [sys.executable, __file__, "--serve", f"{folder}/blank.toml", str(port), deviation]
        with subprocess.Popen(words, cwd=folder) as process:
            try:
                _wait_for(port, process)
                yield port
            finally:
                process.terminate()
                process.wait(30)


def _wait_for(port: int, process: subprocess.Popen[bytes]) -> None:
    end = monotonic() + 60
    while monotonic() < end and process.poll() is None:
        try:
            socket.create_connection(("127.0.0.1", port), timeout=1).close()
        except OSError:
            process.poll()
        else:
            return
    raise SystemExit("the rack does not answer")


def played(plan: ScenePlan, names: tuple[str, ...], deviation: str, counter: bool) -> list[PlayedScene]:
    """Play scenes on a rack of its own."""
    tags = ModuleTags(1, "Scan", SCAN_NS) if counter else ModuleTags(1)
    with served(deviation) as port, closing(connect(f"127.0.0.1:{port},0")) as client:
        path = LogixPath(client, tags)
        chosen = [each for each in plan.scenes if not each.needs and (not names or each.name in names)]
        return [play(scene, path, plan) for scene in chosen]


def unchanged(plan: ScenePlan, runs: int, counter: bool, names: tuple[str, ...]) -> bool:
    """Report runs of an unchanged module; return whether none differs."""
    wrong = 0
    for run in range(runs):
        begin = perf_counter()
        scenes = played(plan, names, "", counter)
        middle = perf_counter()
        found = [search(each.moments, Amci3601, plan.timing) for each in scenes]
        differs = [s.name for s, f in zip(scenes, found, strict=True) if f.unexplained is not None]
        still_open = [s.name for s, f in zip(scenes, found, strict=True) if f.many or s.note]
        wrong += bool(differs)
        print(
            f"run {run + 1:2}: {sum(each.reads for each in found):6,} reads, hypotheses up to "
            f"{max(each.most for each in found):4}, played {middle - begin:3.0f} s, "
            f"judged {perf_counter() - middle:3.0f} s, differs {differs}, open {still_open}",
            flush=True,
        )
    print(f"unchanged: {runs - wrong} of {runs} runs without a difference")
    return not wrong


def deviating(plan: ScenePlan, counter: bool) -> bool:
    """Report ten deviations; return whether eight are told, and none ends as the manual."""
    told = manual = 0
    for name, deviation in DEVIATIONS.items():
        judge = Judge(plan.firmware, plan.timing)
        scenes = [judge.judge(each) for each in played(plan, deviation.scenes, name, counter)]
        differing = [each for each in scenes if each.verdict is ConformVerdict.DIFFERS]
        told += bool(differing)
        manual += all(each.verdict is ConformVerdict.AS_MANUAL for each in scenes)
        known = (
            (*each.readings, *each.rules, *(scale.sentence for scale in each.scales)) for each in differing
        )
        by = sorted({why for reasons in known for why in reasons})
        where = ", ".join(each.name for each in differing) or "nowhere"
        print(f"{name:18} differs in: {where}; explained by: {', '.join(by) or 'nothing known'}", flush=True)
    print(f"deviations: {told} of {len(DEVIATIONS)} told, {manual} as the manual")
    return told >= 8 and not manual


def factors(plan: ScenePlan, counter: bool) -> bool:
    """Report modules that are off by a factor; return whether each is told within its uncertainty."""
    good = True
    for name, (what, factor) in FACTORS.items():
        judge = Judge(plan.firmware, plan.timing)
        for each in played(plan, ("relative moves", "a longer move"), name, counter):
            judge.judge(each)
        found = fitted_scales(judge.conclude())
        good &= [each.what for each in found if each.low < factor < each.high] == [what]
        print(f"{name:18} told as: {' '.join(each.sentence for each in found) or 'nothing'}", flush=True)
    return good


def smoke() -> bool:
    """Play a scene without a socket: unchanged, and with Stopped missing."""
    sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))
    from simulated_path import SimulatedPath

    plan = load_plan("quick")
    plan = replace(plan, timing=replace(plan.timing, scan_ns=SCAN_NS))
    scene = next(each for each in plan.scenes if each.name == "the end")
    made: list[Callable[[], Amci3601]] = [Amci3601, lambda: Altered3601(STATEMENTS["STS-M03"])]
    scenes = [play(scene, SimulatedPath(each(), plan.timing), plan) for each in made]
    found = [search(each.moments, Amci3601, plan.timing) for each in scenes]
    print(f"{found[0].reads} reads explained, {found[1].reads} up to the difference")
    return found[0].explains_all and found[1].unexplained is not None


def main() -> int:
    """Return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--runs", type=int, default=2)
    parser.add_argument("--plan", default="quick")
    parser.add_argument("--without-counter", action="store_true")
    parser.add_argument("--only", choices=("unchanged", "deviations", "factors"))
    parser.add_argument("--scene", default="", help="only this one, of an unchanged module")
    parser.add_argument("--smoke", action="store_true")
    parser.add_argument("--serve", nargs=3, metavar=("RACK", "PORT", "DEVIATION"), help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.serve:
        serve(given.serve[0], int(given.serve[1]), given.serve[2])
        return 0
    if given.smoke:
        return 0 if smoke() else 1
    plan = load_plan(given.plan)
    plan = replace(plan, timing=replace(plan.timing, scan_ns=SCAN_NS if given.without_counter else 0))
    counter, names = not given.without_counter, (given.scene,) if given.scene else ()
    parts = {
        "unchanged": lambda: unchanged(plan, given.runs, counter, names),
        "deviations": lambda: deviating(plan, counter),
        "factors": lambda: factors(plan, counter),
    }
    results = [part() for name, part in parts.items() if given.only in (None, name)]
    good = all(results)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
