"""The operator panel: its file, what its items are bound to, saving it, presses that end by themselves.

Broken on purpose: comments dropped in `_comments`, `base` not compared in `save`, `by` not left out while it
is empty, `let_go` not called in `leave`, an overlap allowed in `_take`: a test turns red.
"""

import json
import os
import re
import shutil
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from amounts import amount
from hypothesis import given, settings
from hypothesis import strategies as st
from live_sessions import FEEDER, LiveSession
from recordings import opened
from scanrack.commands import build
from scanrack.jobs import load_job
from scanrack.jobs.trust.attachments import files_beside
from scanrack.runtime.live.actions import action_of, text_of
from scanrack.runtime.live.operator_actions import sentence
from scanrack.runtime.live.ring import REQUESTS
from scanrack.traces import open_trace
from scanrack.watch.history import recorded_events
from scanrack.watch.history.event_log import EventLog
from scanrack.watch.monitors import panel_questions, session_monitor
from scanrack.watch.monitors.monitor import SessionFacts, Subject
from scanrack.watch.monitors.page import Page
from scanrack.watch.monitors.questions import handle_message as ask
from scanrack.watch.monitors.session_monitor import SessionMonitor, SessionProgram, Setup
from scanrack.watch.panels import bindings
from scanrack.watch.panels.kept_panel import KeptPanel
from scanrack.watch.panels.panel_file import COLORS, COLUMNS, KINDS, Panel, panel_text, parse_panel, refusals
from typer.testing import CliRunner

LAMP = {"name": "Even", "kind": "lamp", "tag": "Even", "at": [0, 0], "size": [2, 2]}
GAUGE = {**LAMP, "name": "Count", "kind": "gauge", "tag": "Count", "at": [2, 0], "least": 0, "most": 20}
TEXT = """\
# Panel of the counter

# lit in every other scan
[[item]]
name = "Even"
kind = "lamp"
tag = "Even"
at = [0, 0]
size = [2, 2]
color = "green"

[[item]]
name = "Count"
kind = "gauge"
tag = "Count"
at = [2, 0]
size = [3, 3]
least = 0
most = 20.5
unit = "°C"
"""


# --- the file


def test_a_file_is_written_as_it_was_read():
    panel = parse_panel(TEXT)
    assert panel.head == ["# Panel of the counter"]
    assert [each["name"] for each in panel.items] == ["Even", "Count"]
    assert panel_text(panel) == TEXT


def test_a_change_of_an_item_changes_its_lines_only():
    panel = parse_panel(TEXT)
    panel.items[1]["at"] = [5, 4]
    assert panel_text(panel) == TEXT.replace("at = [2, 0]", "at = [5, 4]")


def test_comments_stay_with_their_item_and_keys_get_their_order():
    keys = {"name": '"Even"', "kind": '"lamp"', "tag": '"Even"', "at": "[0, 0]", "size": "[2, 2]"}
    lines = [f"{key} = {value}\n" for key, value in keys.items()]
    last, *others = reversed(lines)
    written = "".join(["# one\n[[item]]\n", last, "# two\n", *others, "# three\n"])
    assert panel_text(parse_panel(written)) == "".join(["# one\n# two\n# three\n[[item]]\n", *lines])


WORDS = st.text(st.characters(exclude_categories=("C", "Z")), min_size=1, max_size=12)
NUMBERS = st.integers(-(1 << 53) + 1, (1 << 53) - 1) | st.floats(-1e15, 1e15)


@st.composite
def items(draw: st.DrawFn) -> list[dict[str, object]]:
    """Items of all kinds, one beneath the other."""
    found = []
    for row, name in enumerate(draw(st.lists(WORDS, max_size=5, unique=True))):
        kind = draw(st.sampled_from(sorted(KINDS)))
        width = draw(st.integers(1, COLUMNS))
        item: dict[str, object] = {"name": name, "kind": kind, "tag": draw(WORDS), "size": [width, 1]}
        item["at"] = [draw(st.integers(0, COLUMNS - width)), row]
        least, most = sorted(draw(st.tuples(NUMBERS, NUMBERS).filter(lambda pair: pair[0] != pair[1])))
        values = draw(st.lists(NUMBERS, min_size=3, max_size=3, unique=True))
        given: dict[str, object] = {
            "least": least,
            "most": most,
            "positions": ["a", "b", "c"],
            "values": values,
        }
        given |= {
            "unit": draw(WORDS),
            "decimals": draw(st.integers(0, 6)),
            "color": draw(st.sampled_from(COLORS)),
        }
        may = draw(st.sets(st.sampled_from(KINDS[kind].optional))) if KINDS[kind].optional else set()
        item |= {key: given[key] for key in (*KINDS[kind].needs, *may)}
        lines = draw(st.lists(WORDS.map(lambda text: f"# {text}"), max_size=2))
        found.append(item | ({"comment": lines} if lines else {}))
    return found


@settings(max_examples=amount(40))
@given(items(), st.lists(WORDS.map(lambda text: f"# {text}"), max_size=2))
def test_what_is_saved_is_loaded_and_saved_the_same(found, head):
    text = panel_text(Panel(found, head))
    panel = parse_panel(text)
    assert panel_text(panel) == text
    assert list(panel.items) == found or not found


FREE = {**LAMP, "name": "B", "at": [4, 4]}


def with_(key, value, base=GAUGE):
    return [LAMP, {**base, key: value}]


@pytest.mark.parametrize(
    ("items", "refusal"),
    [
        (with_("name", ""), 'item 2: name "": must be text of 1 to 40 printable characters'),
        (with_("name", "Even"), "item Even: another item has this name"),
        (with_("kind", "knob"), 'item Count: kind "knob": must be momentary, maintained, selector, lamp'),
        (with_("tag", 7), "item Count: tag 7: must be the name of a tag"),
        (with_("at", [12, 0]), "item Count: at [12, 0]: must be [column, row], columns 0 to 11"),
        (with_("at", [11, 0]), "item Count: at [11, 0] size [2, 2]: must end within 12 columns and 60 rows"),
        (with_("at", [1, 1]), "item Count: at [1, 1]: Even is there; must be free"),
        (with_("at", [True, 0]), "item Count: at [true, 0]: must be [column, row]"),
        (with_("size", [0, 1]), "item Count: size [0, 1]: must be [width, height], 1 to 12 and 1 to 8"),
        (with_("least", 20), "item Count: most 20: must be more than least, 20"),
        (with_("most", float("inf")), "item Count: most Infinity: must be a number"),
        (with_("decimals", 7), "item Count: decimals 7: must be 0 to 6"),
        (with_("unit", "x" * 13), 'item Count: unit "xxxxxxxxxxxxx": must be text of 1 to 12'),
        (with_("color", "green"), 'item Count: color "green": gauge has name, kind, tag, at, size, '),
        (with_("color", "pink", FREE), 'item B: color "pink": must be green, red'),
        (with_("comment", ["no"]), 'item Count: comment ["no"]: must be lines that begin with #'),
        ([{key: GAUGE[key] for key in GAUGE if key != "most"}], "item Count: it needs most, a number"),
        (
            with_("values", [1], {**FREE, "kind": "selector", "positions": ["a", "b"]}),
            "item B: values [1]: must be different numbers, one for each position",
        ),
        (
            with_("positions", ["a", "a"], {**FREE, "kind": "selector"}),
            'item B: positions ["a", "a"]: must be 2 to 8 different texts',
        ),
    ],
)  # fmt: skip
def test_a_bad_item_is_refused_with_its_name_its_value_and_what_is_allowed(items, refusal):
    (found,) = refusals(items).values()
    assert found.startswith(refusal)


@pytest.mark.parametrize(
    ("text", "refusal"),
    [
        (TEXT.replace("least = 0", "least = 30"), "item Count: most 20.5: must be more than least, 30"),
        ("columns = 8\n", "no key columns: a panel has [[item]] tables only"),
        ("item = 3\n", "item must be tables: [[item]]"),
        ("[[item]\n", "not TOML: "),
        ("[[item]]\n" * 101, "101 items: a panel has up to 100"),
    ],
)
def test_a_bad_file_is_refused(text, refusal):
    with pytest.raises(ValueError, match=f"^{re.escape(refusal)}"):
        parse_panel(text)


# --- what the items are bound to


def bound(rack, **item):
    """Return the binding of an item in the session of a rack."""
    job = load_job(str(rack))
    subject = Subject(job.spec, (), np.dtype([]), None)
    return subject.bindings(subject.programs.add(0, job.logic, job.program)).binding_of(
        {"kind": "lamp", **item}
    )


LINE = FEEDER.parents[1] / "three_stations_panel" / "line.toml"


@pytest.mark.parametrize(
    ("rack", "item", "expected"),
    [
        (LINE, {"tag": "Run"}, {"read": "Run", "type": "BOOL", "write": "Run", "broken": ""}),
        (LINE, {"tag": "Lamp"}, {"read": "Local:3:O.Data[0].0", "type": "BOOL", "broken": ""}),
        # the stop button of the card is normally closed: at rest it is on
        (
            LINE,
            {"tag": "Stop", "kind": "momentary"},
            {"read": "Local:2:I.Data[0].1", "type": "BOOL", "press": [2, "stop", True], "broken": ""},
        ),
        (
            LINE,
            {"tag": "slot2.input.start", "kind": "maintained"},
            {"read": "Local:2:I.Data[0].0", "type": "BOOL", "press": [2, "start", False], "broken": ""},
        ),
        (
            FEEDER,
            {"tag": "slot1.input.estop", "kind": "maintained"},
            {"read": "1.input.estop", "type": "BOOL", "press": [1, "estop", False], "broken": ""},
        ),
        # a switch that the machine operates goes back to it
        (
            FEEDER,
            {"tag": "slot1.input.home", "kind": "momentary"},
            {"read": "1.input.home", "type": "BOOL", "press": [1, "home", None], "broken": ""},
        ),
        (FEEDER, {"tag": "Quiet.ACC", "kind": "entry"}, {"type": "DINT", "write": "Quiet.ACC", "broken": ""}),
        (FEEDER, {"tag": "Words[2]", "kind": "gauge"}, {"type": "INT", "broken": ""}),
        (FEEDER, {"tag": "Feding"}, {"read": "", "broken": "no tag Feding; did you mean Feeding, Homing?"}),
        (FEEDER, {"tag": "xyzzy"}, {"broken": "no tag xyzzy"}),
        (FEEDER, {"tag": "Quiet.ACC"}, {"broken": "Quiet.ACC is DINT: lamp needs BOOL"}),
        (
            FEEDER,
            {"tag": "Quiet", "kind": "display"},
            {"broken": "Quiet is a structure or an array: display needs one value"},
        ),
        (
            LINE,
            {"tag": "Lamp", "kind": "momentary"},
            {"broken": "Lamp can't be set: momentary needs a tag of the program or an input"},
        ),
    ],
)
def test_an_item_is_bound_to_a_tag_an_alias_or_an_input(rack, item, expected):
    found = bound(rack, **item)
    assert {key: found.get(key) for key in expected} == expected


def test_names_are_suggested_for_a_few_unknown_tags_and_looked_up_once(monkeypatch):
    """Pages wait meanwhile: a message of 100 unknown tags took 20 s of a program with 5,000."""
    asked_for: list[tuple[str, int]] = []

    def near(wanted, names, *_limits):
        asked_for.append((wanted, len(names)))
        return names[:1]

    monkeypatch.setattr(bindings, "get_close_matches", near)
    tags = [{"name": f"{'AB'[each % 2]}{each}", "type": "BOOL", "writable": True} for each in range(5000)]
    job = load_job(str(FEEDER))
    subject = Subject(job.spec, (), np.dtype([]), None)
    program = subject.programs.add(0, job.logic, job.program)
    for lamps, hints in ((range(100), 5), (range(3), 3), (range(100), 10)):
        found = bindings.Bindings(program, [], tags)
        said = [found.binding_of({"kind": "lamp", "tag": f"b-{each}"})["broken"] for each in lamps]
        assert [each.partition("; ")[2] for each in said[:hints]] == ["did you mean B1?"] * hints
        assert all("; " not in each for each in said[hints:])
    assert asked_for == [(f"B-{each}", bindings.COMPARED_MOST) for each in range(10)]
    monkeypatch.undo()
    tags.append({"name": "Station", "type": "BOOL", "writable": True})
    found = bindings.Bindings(program, [], tags)
    assert (
        found.binding_of({"kind": "lamp", "tag": "Btatoin"})["broken"]
        == "no tag Btatoin; did you mean Station?"
    )


# --- a file that is none


@pytest.mark.parametrize("kind", ["pipe", "secret"])
def test_a_panel_that_is_a_pipe_or_a_link_to_a_secret_is_neither_read_nor_recorded(rack, kind):
    """A rack of strangers may bring `feeder.panel -> ~/.ssh/id_rsa`; its trace goes back to them."""
    panel, secret = rack.with_suffix(".panel"), rack.with_name("id_rsa")
    secret.write_text("secret", encoding="utf-8")
    if kind == "pipe":
        os.mkfifo(panel)
    else:
        panel.symlink_to(secret)
    kept = KeptPanel(str(rack))
    with pytest.raises(ValueError, match=r"it can't be read: it is a (pipe|link)"):
        kept.content()
    assert panel.name not in files_beside(load_job(str(rack)))


# --- in a session


class Sent(SimpleNamespace):
    """The pipe of a monitor: the orders that it has passed on."""

    def send_bytes(self, message):
        self.orders.append(json.loads(message)["order"])


@pytest.fixture
def rack(tmp_path):
    for name in ("feeder.toml", "feeder.rung"):
        shutil.copy(FEEDER.with_name(name), tmp_path)
    return tmp_path / "feeder.toml"


@pytest.fixture
def monitor(rack):
    yield from monitored(rack, read_only=False)


@pytest.fixture
def read_only(rack):
    yield from monitored(rack, read_only=True)


def monitored(rack, *, read_only, session=None, started=0):
    session = session or LiveSession(rack=rack)
    ran = SessionProgram(0, str(rack.parent), "feeder.toml", "feeder.rung")
    about = SessionFacts("0", "feeder", str(rack), "rack", read_only, False, None)
    setup = Setup(session.ring.shape, about, "", "", 0, (1,), str(rack.with_suffix(".mcap")), (ran,), started)
    found: Any = SessionMonitor(setup, session.ring, Sent(orders=[]))  # type: ignore[arg-type]
    found.sent = found._pipe.orders
    with session.ports:
        yield found


def joined(monitor):
    page = Page()
    monitor.join(page)
    return page


def asked(monitor, page, do, **fields):
    page.outbox.clear()
    ask(monitor, page, {"id": 1, "do": do, **fields})
    return page.outbox[-1]["answer"]


STOP = {"name": "E-stop", "kind": "momentary", "tag": "slot1.input.estop", "at": [0, 0], "size": [2, 2]}


def test_a_panel_is_saved_beside_the_rack_and_shown_to_the_other_pages(monitor, rack):
    page, other = joined(monitor), joined(monitor)
    told = asked(monitor, page, "panel")
    assert (told["file"], told["items"], told["base"]) == ("feeder.panel", [], "")
    other.outbox.clear()
    said = asked(monitor, page, "save_panel", items=[STOP], base="")
    assert parse_panel(rack.with_suffix(".panel").read_text("utf-8")).items == [STOP]
    assert [each["panel"]["items"] for each in other.outbox] == [[STOP]]
    assert said["items"] == asked(monitor, page, "panel")["items"] == [STOP]


def test_a_file_that_somebody_has_changed_meanwhile_stays(monitor, rack):
    page, file = joined(monitor), rack.with_suffix(".panel")
    base = asked(monitor, page, "save_panel", items=[STOP], base="")["base"]
    changed = f"# mine\n{file.read_text('utf-8')}"
    file.write_text(changed, encoding="utf-8")
    said = asked(monitor, page, "save_panel", items=[], base=base)
    assert said["refused"] == "feeder.panel was changed meanwhile: discard your changes, then edit again"
    assert file.read_text("utf-8") == changed


def test_a_changed_file_is_shown_and_a_broken_one_named(monitor, rack):
    page, file = joined(monitor), rack.with_suffix(".panel")
    file.write_text(panel_text(Panel([{**STOP, "size": [99, 1]}])), encoding="utf-8")
    page.outbox.clear()
    for _ in range(session_monitor.PANEL_TICKS):
        monitor.tick()
    (told,) = [each["panel"] for each in page.outbox if "panel" in each]
    assert told["mistake"].startswith("feeder.panel: item E-stop: size [99, 1]: must be [width, height]")
    assert "refused" in asked(monitor, page, "save_panel", items=[], base=told["base"])
    assert "99" in file.read_text("utf-8")


def test_a_bad_item_of_a_page_is_not_saved(monitor, rack):
    page = joined(monitor)
    said = asked(monitor, page, "save_panel", items=[{**STOP, "tag": ""}], base="")
    assert said["refused"].startswith('item E-stop: tag "": must be the name of a tag')
    assert not rack.with_suffix(".panel").exists()
    drafted = asked(monitor, page, "panel", items=[{**STOP, "tag": ""}, {**LAMP, "at": [4, 0]}])
    assert [each["broken"][:14] for each in drafted["bound"]] == ["item E-stop: t", "no tag Even; d"]


def test_a_read_only_page_sees_the_panel_and_changes_nothing(read_only, rack):
    rack.with_suffix(".panel").write_text(panel_text(Panel([STOP])), encoding="utf-8")
    page = joined(read_only)
    told = asked(read_only, page, "panel")
    assert (told["items"], told["lacks"]) == ([STOP], "this session is read-only")
    for do, fields in (
        ("save_panel", {"items": [], "base": told["base"]}),
        ("hold", {"give": []}),
        ("press", {"slot": 1, "name": "estop", "on": True, "by": "panel"}),
    ):
        assert "read-only" in asked(read_only, page, do, **fields)["refused"]


# --- presses that end by themselves

PRESS = {"do": "press", "slot": 1, "name": "estop", "on": True, "by": "panel"}
RELEASE = {**PRESS, "on": False}


def test_a_closed_page_lets_go_what_it_presses(monitor):
    joined(monitor)
    page = joined(monitor)
    asked(monitor, page, "hold", give=[RELEASE])
    ask(monitor, page, {"id": 2, **PRESS})
    monitor.leave(page)
    assert monitor.sent == [{**PRESS, "by": "panel, page 2"}, {**RELEASE, "by": "panel, page 2"}]


def test_a_page_that_says_nothing_any_more_lets_go(monitor, monkeypatch):
    page, now = joined(monitor), [0]
    monkeypatch.setattr(panel_questions, "wall_ns", lambda: now[0])
    monkeypatch.setattr(session_monitor, "wall_ns", lambda: now[0])
    for ms, held in ((0, True), (1999, True), (2100, False)):
        now[0] = ms * 1_000_000
        monitor.tick()
        if ms == 1999:
            assert monitor.sent == []
        assert bool(page.releases) is (ms > 0 and held)
        if ms == 0:
            asked(monitor, page, "hold", give=[RELEASE])
    assert monitor.sent == [{**RELEASE, "by": "panel, page 1"}]
    assert any("were released" in each.get("note", "") for each in page.outbox)


@pytest.mark.parametrize("give", ["x", [{"do": "mode", "mode": "run"}], [{"do": "press"}], [RELEASE] * 21])
def test_only_presses_and_writes_are_kept_for_that(monitor, give):
    page = joined(monitor)
    assert "refused" in asked(monitor, page, "hold", give=give)
    assert page.releases == []


def test_a_branch_lets_go_what_a_page_presses_once(monitor):
    page = joined(monitor)
    asked(monitor, page, "hold", give=[RELEASE])
    ran = monitor.ran
    told = {"record": None, "trace": "none.mcap", "rows": 0, "snapshots": 0}
    monitor._take_branch({**told, "programs": [(ran.first, ran.place, ran.rack, ran.program)]})
    assert page.releases == []
    assert monitor.sent == [{**RELEASE, "by": "panel, page 1"}]


SWITCH = {**STOP, "name": "Switch", "kind": "maintained", "tag": "slot1.input.capture", "at": [2, 0]}
JOG = {**STOP, "name": "Jog", "tag": "Homing", "at": [4, 0]}
LEFT = [
    (PRESS, [RELEASE]),
    ({**PRESS, "on": False}, []),
    ({**PRESS, "by": ""}, []),  # of a key of the machine's part of the page: it stays
    ({**PRESS, "name": "capture"}, []),  # a switch stays
    ({"do": "write", "tag": "Homing", "value": True}, [{"do": "write", "tag": "Homing", "value": False}]),
]


@pytest.mark.parametrize(("last", "released"), LEFT)
def test_a_restarted_monitor_lets_go_what_was_left_pressed_once(rack, last, released):
    rack.with_suffix(".panel").write_text(panel_text(Panel([STOP, SWITCH, JOG])), encoding="utf-8")
    order = {"by": "panel, page 3", **last}
    session = LiveSession([(1, order)], rack.with_suffix(".mcap"), rack)
    session.ring.head[REQUESTS] += 1  # the monitor before: for values
    session.play(20)
    by = {"by": "panel, after a restart"}
    for started, expected in ((0, []), (1, [{**each, **by} for each in released])):
        for monitor in monitored(rack, read_only=False, session=session, started=started):
            for _ in range(2):
                monitor._indexed = False  # as after a branch
                monitor.tick()
            assert monitor.sent == expected
            monitor.subject.timeline.close()


def test_a_restarted_monitor_knows_presses_of_the_whole_recording(rack, monkeypatch):
    """Also those that are further back than what it reads at once; while the recording grows."""
    monkeypatch.setattr(recorded_events, "AT_ONCE", 0)
    rack.with_suffix(".panel").write_text(panel_text(Panel([STOP])), encoding="utf-8")
    on, write = {**PRESS, "by": "panel, page 3"}, {"do": "write", "tag": "Homing", "value": True, "by": "x"}
    session = LiveSession([(1, on), (2, write)], rack.with_suffix(".mcap"), rack)
    session.ring.head[REQUESTS] += 1
    session.play(20)
    for _ in range(8):  # what the monitor before has read is overwritten
        session.ring.messages.write(b'{"note":""}' + b" " * (1 << 17))
    for monitor in monitored(rack, read_only=False, session=session, started=1):
        while monitor.tick():
            pass
        monitor.log.take({"scan": 15, "t": 0, "topic": "/orders", "text": "?", "order": '{"do":"pause"}'})
        pressed = {"1.input.estop": [True, "panel, page 3"], "Homing": [True, "x"]}
        assert monitor.states.pressed_at(None) == pressed
        monkeypatch.setattr(monitor.log.earlier, "_up_to", lambda places, scan: places + [9][: scan > 15])
        assert monitor.states.pressed_at(None) == pressed  # a new chunk that is not read yet
        assert monitor.sent == [{**RELEASE, "by": "panel, after a restart"}]
        monitor.subject.timeline.close()


def test_a_restarted_monitor_leaves_what_a_page_holds_again(monitor):
    press = {**PRESS, "by": "panel, page 1"}
    event = {"scan": 1, "t": 0, "topic": "/orders", "text": "?", "order": json.dumps(press)}
    page = joined(monitor)
    asked(monitor, page, "save_panel", items=[STOP], base="")
    monitor.log.take(event)
    assert panel_questions.left_pressed(monitor) == [RELEASE]
    asked(monitor, page, "hold", give=[RELEASE])
    assert panel_questions.left_pressed(monitor) == []


# --- what recordings have of it


def test_an_order_says_who_has_given_it_if_somebody_did():
    order = action_of({**PRESS, "by": "panel, page 1"})
    assert text_of(order) == ('{"do":"press","slot":1,"name":"estop","on":true,"by":"panel, page 1"}')
    assert sentence(order) == "Slot 1: the estop input is energized (panel, page 1)."
    plain = {key: value for key, value in PRESS.items() if key != "by"}
    assert text_of(action_of(plain)) == json.dumps(plain, separators=(",", ":"))


WRITE = {"do": "write", "tag": "Step", "value": 5, "by": "panel, page 1"}


def test_a_trace_brings_the_panel_and_what_was_pressed_in_each_scan(rack):
    rack.with_suffix(".panel").write_text(panel_text(Panel([STOP])), encoding="utf-8")
    trace, write = rack.with_suffix(".mcap"), {**WRITE, "tag": "Quiet.PRE"}
    LiveSession([(10, PRESS), (20, RELEASE), (30, write)], trace, rack).play(50)
    with opened(trace, rack.parent / "files", 5) as seen:
        seen.settle()
        told = asked(seen.monitor, seen.page, "panel")
        assert (told["items"], told["lacks"]) == ([STOP], "this is a recording")
        # an order acts before the scan after the one that it came in
        pressed = {scan: seen.look(scan)["pressed"] for scan in (10, 11, 20, 21, 31)}
    on, off = ([level, "panel"] for level in (True, False))
    assert pressed[10] == {}
    assert pressed[11] == pressed[20] == {"1.input.estop": on}
    assert pressed[21] == {"1.input.estop": off}
    assert pressed[31] == {"1.input.estop": off, "Quiet.PRE": [5, "panel, page 1"]}


def test_a_session_with_a_panel_repeats_byte_for_byte(rack, monkeypatch):
    """The trace brings the panel, and the repeated one has it, too."""
    monkeypatch.chdir(rack.parent)
    rack.with_suffix(".panel").write_text(panel_text(Panel([STOP])), encoding="utf-8")
    LiveSession([(10, PRESS), (20, RELEASE)], Path("first.mcap"), rack).play(50)
    done = CliRunner().invoke(
        build(), ["replay", "first.mcap", "--into", "session", "--record", "again.mcap"]
    )
    assert done.exit_code == 0, done.output
    with open_trace("again.mcap") as again:
        names = [each.name for each in again.attachments()]
    assert "feeder.panel" in names
    assert Path("again.mcap").read_bytes() == Path("first.mcap").read_bytes()


def test_an_order_that_can_not_be_read_presses_nothing():
    log = EventLog()
    for order in ("{", '{"do":"press"}', '{"do":"mode","mode":"run"}'):
        log.take({"scan": 1, "t": 0, "topic": "/orders", "kind": "order", "text": "?", "order": order})
    assert log.pressed_at(None) == {}
