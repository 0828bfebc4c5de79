"""A campaign on a Dask cluster of two workers, of which one is killed in the middle."""

import os
import signal

import pytest
from scanrack.jobs import Kind, State
from scanrack.jobs.fuzz.campaign.campaign import campaign
from scanrack.jobs.fuzz.campaign.executors import executor_of
from scanrack.jobs.fuzz.campaign.working import Work
from scanrack.jobs.fuzz.job import Setup

distributed = pytest.importorskip("distributed", reason="the extra 'cluster' is not installed")
pytestmark = pytest.mark.extra("cluster")

PROGRAM = """
def logic(scan):
    if scan.number > 50 and scan.slot[1].inputs[1] == 0 and scan.slot[1].inputs[0] == 0:
        raise RuntimeError("the module has gone")
"""
RACK = """program = "line.py"
run_for_s = 0.4
[[slot]]
number = 1
module = "amci3601"
"""
TASKS = 3


@pytest.fixture
def cluster():
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
    ) as made:
        yield made


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_a_campaign_outlives_a_worker(tmp_path, cluster):
    (tmp_path / "line.py").write_text(PROGRAM, encoding="utf-8")
    rack = tmp_path / "line.toml"
    rack.write_text(RACK, encoding="utf-8")
    workers = sorted(worker["pid"] for worker in _told(cluster).values())
    state = State()
    killed: list[object] = []

    def news(found):
        if not killed:
            killed.append(workers[0])
            os.kill(workers[0], signal.SIGKILL)

    # in the worker itself, which has one thread; test_fuzz_scheduler proves `Apart`
    work = Work(Setup(str(rack), (), ("no-command-error",), 100, frozenset({Kind.LINK})))
    executor = executor_of(2, cluster.scheduler_address)
    campaign(work, state, executor, examples=12, tasks=TASKS, jobs=2, news=news)
    assert killed
    assert state.tasks == TASKS
    assert sorted(state.found) == ["no-fault line.py:4"]
    assert state.runs >= 12


def _told(cluster):
    with distributed.Client(cluster.scheduler_address) as client:
        return {address: {"pid": pid} for address, pid in client.run(os.getpid).items()}
