"""Questions of a page with mistakes in them; the rail of a machine; clients of tags while orders repeat."""

import pytest
from recordings import opened, recorded
from scanrack.commands import build
from scanrack.jobs import load_job
from scanrack.watch.monitors.comparison import recordings_beside
from scanrack.watch.monitors.hello import machine_of, slot_of
from scanrack.watch.monitors.questions import handle_message as ask
from scanrack.watch.play import Play
from scanrack.watch.typed_text import effects_between
from typer.testing import CliRunner


@pytest.fixture(scope="module")
def seen(tmp_path_factory):
    folder = tmp_path_factory.mktemp("questions")
    with opened(recorded(folder, 20), folder, 10) as found:
        found.settle()
        yield found


def asked(seen, do, **fields):
    seen.page.outbox.clear()
    ask(seen.monitor, seen.page, {"id": 1, "do": do, **fields})
    return seen.page.outbox[-1]["answer"]


@pytest.mark.parametrize("text", ["", "x" * 401, 7, None])
def test_a_name_is_text_of_1_to_400_characters(seen, text):
    for do, key in (("why", "tag"), ("xref", "tag"), ("since", "tag"), ("find", "text"), ("show", "routine")):
        assert asked(seen, do, **{key: text}) == {
            "id": 1,
            "refused": f"{key} must be text of 1 to 400 characters",
        }


@pytest.mark.parametrize("text", ["x", "x" * 400])
def test_the_shortest_and_the_longest_name_are_looked_up(seen, text):
    assert f"no tag {text}" in asked(seen, "why", tag=text)["refused"]
    assert "hits" in asked(seen, "find", text=text)


def test_why_is_asked_of_the_scan_of_the_page_or_of_another_one(seen):
    of_page = asked(seen, "why", tag="Count")
    assert of_page["scan"] == seen.page.past
    assert asked(seen, "why", tag="Count", scan=None) == of_page
    assert asked(seen, "why", tag="Count", scan=5)["scan"] == 5
    assert asked(seen, "why", tag="Count", scan=999)["refused"] == "no scan 999"
    assert asked(seen, "why", tag="Count", scan=True)["refused"] == "scan must be a scan number"


@pytest.mark.parametrize(("do", "most"), [("watch", 500), ("lanes", 16)])
@pytest.mark.parametrize("mistake", ["no list", "too many", "an empty name", "a number"])
def test_tags_are_a_list_of_so_many_names(seen, do, most, mistake):
    wrong = {"no list": "Count", "too many": ["Count"] * (most + 1), "an empty name": ["Count", ""]}
    said = asked(seen, do, tags=wrong.get(mistake, [7]))
    assert said["refused"] == f"tags must be a list of up to {most} names"
    assert asked(seen, do, tags=["Count"] * most)["unknown"] == []


@pytest.mark.parametrize(
    ("record", "names"), [("run.mcap", ["beside.mcap"]), (None, ["beside.mcap", "run.mcap"])]
)
def test_recordings_to_compare_with_are_beside_the_own_one_else_beside_the_rack(tmp_path, record, names):
    for name in ("run.mcap", "beside.mcap"):
        (tmp_path / name).touch()
    assert sorted(recordings_beside(tmp_path / (record or "rack.toml"))) == names


LINE = "def logic(scan):\n    pass\n"


def test_a_recording_of_a_program_that_may_not_run_has_no_branch(tmp_path):
    (tmp_path / "line.py").write_text(LINE, encoding="utf-8")
    (tmp_path / "line.toml").write_text(
        'program = "line.py"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n', encoding="utf-8"
    )
    words = [
        "run",
        str(tmp_path / "line.toml"),
        "--scans",
        "20",
        "--record",
        str(tmp_path / "line.mcap"),
        "-q",
    ]
    assert CliRunner().invoke(build(), words).exit_code == 0
    for trust in (False, True):
        with opened(tmp_path / "line.mcap", tmp_path / "files", 10, trust=trust) as found:
            said = asked(found, "branch", scan=5)
            assert said.get("refused") == (None if trust else "running the program needs --trust")


def test_only_an_edit_of_rungs_has_effects_that_are_proved(tmp_path):
    rungs = load_job(str(recorded(tmp_path, 1).with_suffix(".toml")))
    (tmp_path / "line.py").write_text(LINE, encoding="utf-8")
    (tmp_path / "line.toml").write_text(
        'program = "line.py"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n', encoding="utf-8"
    )
    python = load_job(str(tmp_path / "line.toml"))
    assert [effects_between(*each) for each in ((python, rungs), (rungs, python), (python, python))] == [
        (),
        (),
        (),
    ]


def test_a_machine_is_shown_of_a_simulated_module_only(tmp_path):
    (tmp_path / "idle.py").write_text(LINE, encoding="utf-8")
    shown = []
    for number, port in enumerate(("", 'port = "tcp:127.0.0.1:1"\n')):
        rack = f'program = "idle.py"\n[[slot]]\nnumber = 1\nmodule = "pcl601-adapter"\n{port}'
        (tmp_path / f"{number}.toml").write_text(rack, encoding="utf-8")
        (slot,) = load_job(str(tmp_path / f"{number}.toml")).spec.slot
        shown.append(slot_of(slot))
    assert [each["machine"] is not None for each in shown] == [True, False]
    assert [bool(each["inputs"]) for each in shown] == [True, False]


RACK = 'program = "idle.py"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n[slot.machine]\n'
MACHINES = [
    (
        "switches = [{ input = 'cw_limit', first = 12000 }, { input = 'ccw_limit', last = -4000 }]",
        -4800,
        12800,
    ),
    ("switches = [{ input = 'home', first = -100, last = 100 }]", -300, 300),
    (
        "switches = [{ input = 'home', first = 8000, last = 8100 }]",
        -405,
        8505,
    ),  # with the place at power-up, 0
    ("stations = [{ position = 10000, input = 'capture', work_s = 1, pulse_ms = 20 }]", -500, 10500),
    ("jams = [{ at = -10000, direction = -1 }]", -10500, 500),
]


@pytest.mark.parametrize(("machine", "least", "most"), MACHINES)
def test_a_rail_has_a_twentieth_of_its_items_at_either_end_and_200_steps_at_least(
    tmp_path, machine, least, most
):
    (tmp_path / "idle.py").write_text("def logic(scan):\n    pass\n", encoding="utf-8")
    (tmp_path / "rack.toml").write_text(RACK + machine + "\n", encoding="utf-8")
    (slot,) = load_job(str(tmp_path / "rack.toml")).spec.slot
    rail = machine_of(slot.machine)
    assert (rail["min"], rail["max"]) == (least, most)


def test_clients_of_tags_wait_while_the_orders_of_a_branch_repeat():
    said: list[bool] = []
    play = object.__new__(Play)
    play._services = type("Services", (), {"rest": lambda _self, rests: said.append(rests)})()
    play._hold_clients(True)
    play._hold_clients(False)
    assert said == [True, False]
    play._services = None
    play._hold_clients(True)
    assert said == [True, False]
