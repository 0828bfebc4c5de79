"""Does the number of workers change a search, and what do two of them gain?

    python benchmarks/fuzz_workers.py [--runs N] [--smoke]

Searches the feeder with the same command on one process, on two (twice), under another hash seed, and on a
Dask cluster of two workers where Dask is installed: all have to make the same steps, as their digests show.

Two processes: the seconds of every task are those of the processor. The gain is what one process needs for
the tasks and between them, divided by what two need that begin a task as soon as they have none and wait for
each other at the end of a round. So it does not depend on what else the machine does; seconds of the wall
clock are shown beside it.

Exit status: 0; 1 if the steps differ.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from pathlib import Path

from scanrack.jobs.fuzz.campaign.campaign import campaign, width
from scanrack.jobs.fuzz.campaign.executors import executor_of
from scanrack.jobs.fuzz.campaign.state import State
from scanrack.jobs.fuzz.campaign.working import OwnProcess, Work
from scanrack.jobs.fuzz.job import Setup, bench_of
from scanrack.jobs.fuzz.scenarios.kinds import kinds_for

FEEDER = Path(__file__).parents[1] / "examples" / "feeder" / "feeder.toml"
SCANS, EXAMPLES, RUNS, BAR = 250, 50, 1_000, 1.8
SMOKE_RUNS, SMOKE_SCANS = 8, 100


def searched(
    runs: int, jobs: int, dask: str | None = None, scans: int = SCANS
) -> tuple[State, list[float], float, float]:
    """Return the state, the seconds of each task, those between the tasks, and those of the wall clock."""
    bare = Setup(str(FEEDER), (), ("no-command-error",), scans, frozenset())
    setup = Setup(str(FEEDER), (), ("no-command-error",), scans, kinds_for(bench_of(bare).spec))
    examples = min(EXAMPLES, runs // 2)
    state, tasks, before = State(), [], [0]
    work = Work(setup)

    def news(_found: object) -> None:
        tasks.append((state.processor_ns - before[0]) / 1e9)
        before[0] = state.processor_ns

    start, own = time.perf_counter(), time.process_time()
    campaign(
        work if dask is None else OwnProcess(work),
        state,
        executor_of(jobs, dask),
        examples=examples,
        tasks=-(-runs // examples),
        jobs=jobs,
        news=news,
    )
    between = time.process_time() - own - (sum(tasks) if jobs == 1 else 0)
    return state, tasks, max(0.0, between), time.perf_counter() - start


def on_workers(tasks: list[float], workers: int) -> float:
    """Return how long workers take that wait for each other at the end of a round."""
    total, done = 0.0, 0
    while done < len(tasks):
        busy = [0.0] * workers
        for seconds in tasks[done : done + width(done)]:
            busy[busy.index(min(busy))] += seconds
        done += width(done)
        total += max(busy)
    return total


def under_another_hash_seed(runs: int) -> str:
    """Return the digest of a search in a process that has another hash seed."""
    code = f"import fuzz_workers; print(fuzz_workers.searched({runs}, 1)[0].steps)"
    environment = os.environ | {"PYTHONHASHSEED": "3601", "PYTHONPATH": str(Path(__file__).parent)}
    told = subprocess.run(
        [sys.executable, "-c", code],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
        encoding="utf-8",
    )
    return told.stdout.split()[-1]


def on_dask(runs: int) -> str | None:
    """Return the digest of a search on a cluster of two workers, None without Dask."""
    try:
        from distributed import LocalCluster
    except ModuleNotFoundError:
        return None
    options = {"dashboard_address": None, "silence_logs": 50}
    with LocalCluster(n_workers=2, threads_per_worker=1, processes=True, **options) as cluster:  # type: ignore[no-untyped-call, unused-ignore]
        return searched(runs, 2, cluster.scheduler_address)[0].steps


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description="The same search on any number of workers.")
    parser.add_argument("--runs", type=int, default=RUNS)
    parser.add_argument("--smoke", action="store_true", help="a few runs on one process and on two")
    given = parser.parse_args(arguments)
    runs, scans = (SMOKE_RUNS, SMOKE_SCANS) if given.smoke else (given.runs, SCANS)
    one, _, _, alone_s = searched(runs, 1, scans=scans)
    two, tasks, between, together_s = searched(runs, 2, scans=scans)
    steps = {"one process": one.steps, "two processes": two.steps}
    if not given.smoke:
        steps["two processes, again"] = searched(runs, 2)[0].steps
        steps["another hash seed"] = under_another_hash_seed(runs)
        steps["Dask, two workers"] = on_dask(runs) or "Dask is not installed"
    print(f"the same {runs:,} steps of examples/feeder ({one.runs:,} runs, {one.scans:,} scans)")
    for name, digest in steps.items():
        print(f"  {name:<22} {digest[:16]}")
    needs, gains = sum(tasks) + between, on_workers(tasks, 2) + between
    print(f"two processes: {needs / gains:.2f} times as fast (bar {BAR}), processor seconds")
    print(f"  one needs            {needs:>8.1f} s, {between:.2f} s of them between the tasks")
    print(f"  two need             {gains:>8.1f} s")
    print(f"  on the wall clock    {alone_s:>8.1f} s and {together_s:.1f} s")
    digests = {each for each in steps.values() if " " not in each}
    return 0 if len(digests) == 1 else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
