"""Orders: what is one, what is not, and what the refusal says."""

import json

import pytest
from scanrack.runtime import Force, Write
from scanrack.runtime.live.actions import (
    ACTIONS,
    DRAFT_MOST,
    MAX,
    RUNGS_MOST,
    TYPED,
    Draft,
    InjectFault,
    Mode,
    Press,
    Speed,
    Step,
    action_of,
    message_of,
    parsed,
    text_of,
)

GOOD = [
    ({"do": "mode", "mode": "program"}, Mode("program")),
    ({"do": "step"}, Step(1)),
    ({"do": "step", "scans": 20}, Step(20)),
    ({"do": "speed", "factor": 0.1}, Speed(0.1)),
    ({"do": "speed", "factor": "max"}, Speed(MAX)),
    ({"do": "press", "slot": 1, "name": "estop", "on": None}, Press(1, "estop", None)),
    ({"do": "write", "tag": "Fill.PRE", "value": 2500}, Write("Fill.PRE", 2500)),
    ({"do": "force", "tag": "Local:1:I.Data[0].3", "value": True}, Force("Local:1:I.Data[0].3", True)),
    (
        {"do": "incident", "kind": "torn-update", "slot": 1, "late_words": [1, 2]},
        InjectFault("torn-update", 1, 0, (1, 2)),
    ),
    (
        {"do": "incident", "kind": "condition", "slot": 1, "state": "stall=now"},
        InjectFault("condition", 1, state="stall=now"),
    ),
]


@pytest.mark.parametrize(("said", "order"), GOOD, ids=lambda each: str(each)[:40])
def test_an_order_is_made_of_its_message_and_makes_it_again(said, order):
    assert action_of(said) == order
    assert action_of(message_of(order)) == order
    assert action_of(parsed(text_of(order))) == order


BAD: list[tuple[object, str]] = [
    (None, "an action must be an object"),
    ([], "an action must be an object"),
    ({}, "no action None"),
    ({"do": "explode"}, "no action 'explode'; choose from mode, pause"),
    ({"do": ["mode"]}, "no action"),
    ({"do": "mode"}, "mode needs mode"),
    ({"do": "mode", "mode": "off"}, "mode: mode 'off' is not allowed: run, program, test"),
    ({"do": "mode", "mode": {}}, "mode: mode {} is not allowed"),
    ({"do": "pause", "why": 1}, "pause has no 'why'; it has no keys"),
    ({"do": "step", "scans": 0}, "step: scans 0 is not allowed: 1 to 1,000,000"),
    ({"do": "step", "scans": True}, "step: scans True is not allowed"),
    ({"do": "step", "scans": 1.5}, "step: scans 1.5 is not allowed"),
    ({"do": "speed", "factor": 0}, "speed: factor 0 is not allowed: 0.01 to 1000, or max"),
    ({"do": "speed", "factor": True}, "speed: factor True is not allowed"),
    ({"do": "press", "slot": "1", "name": "home", "on": True}, "press: slot '1' is not allowed"),
    ({"do": "press", "slot": 1, "name": "", "on": True}, "press: name '' is not allowed"),
    ({"do": "press", "slot": 1, "name": "home", "on": 1}, "press: on 1 is not allowed: true, false or null"),
    ({"do": "write", "tag": "a\x1b", "value": 1}, "write: tag"),
    ({"do": "write", "tag": "a", "value": None}, "write: value None is not allowed"),
    ({"do": "write", "tag": "a", "value": 1 << 70}, "write: value"),
    ({"do": "write", "tag": "a", "value": [1]}, "write: value"),
    ({"do": "incident", "kind": "program-mode", "slot": 1}, "incident: kind 'program-mode' is not allowed"),
    ({"do": "incident", "kind": "removed", "slot": 1, "for_ms": -1}, "incident: for_ms -1 is not allowed"),
    ({"do": "incident", "kind": "removed", "slot": 1, "late_words": [250]}, "incident: late_words"),
]


@pytest.mark.parametrize(("said", "says"), BAD, ids=lambda each: str(each)[:40])
def test_what_is_no_order_is_refused_with_what_is_allowed(said, says):
    with pytest.raises(ValueError) as refusal:  # noqa: PT011 - the text is compared
        action_of(said)
    assert says in str(refusal.value)


def test_numbers_that_json_does_not_have_are_refused():
    for text in ("NaN", '{"do":"write","tag":"a","value":Infinity}'):
        with pytest.raises(ValueError, match="JSON has no such number"):
            parsed(text)


def test_what_is_nested_too_deep_for_its_reader_is_refused(monkeypatch):
    def deep(*_args, **_named):
        raise RecursionError

    monkeypatch.setattr(json, "loads", deep)
    with pytest.raises(ValueError, match="nested too deep"):
        parsed("[]")


def test_every_order_can_be_named():
    assert {name for name, kind in ACTIONS.items() if kind.__name__ == "InjectFault"} == {"incident"}
    assert len(ACTIONS) == len(set(ACTIONS.values()))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('{"do": "write", "tag": "T", "value": "\\ud800"}', "half of a surrogate pair"),
        ('{"\\udfff": 1}', "half of a surrogate pair"),
        ("[" * 10 + "]" * 10, "nested too deep"),
    ],
)
def test_what_json_can_say_and_no_page_can_show_is_refused(text, says):
    with pytest.raises(ValueError, match=says):
        parsed(text)


def test_a_number_that_no_float_holds_is_refused():
    for said in (
        {"do": "speed", "factor": 10**400},
        {"do": "incident", "kind": "torn-update", "slot": 1, "for_ms": 10**400},
        {"do": "write", "tag": "T", "value": "\ud800"},
    ):
        with pytest.raises(ValueError, match="is not allowed"):
            action_of(said)


def test_a_draft_has_a_text_that_fits_a_message():
    most = "ä" * (DRAFT_MOST // 2 - 1)  # two bytes each, and the quotation marks
    assert action_of({"do": "draft", "text": most, "base": "0"}, TYPED) == Draft(most, "0")
    for text in (most + "ä", "\n" * (DRAFT_MOST // 2), "\ud800", 7):
        with pytest.raises(ValueError, match="text of up to 60,000 bytes"):
            action_of({"do": "draft", "text": text, "base": "0"}, TYPED)


def test_a_draft_has_rungs_that_are_drawn_at_once():
    """Without the limit a message of `;` would be 15,000 pictures."""

    def online(*counts):
        rungs = [["Main", number, [";"] * count] for number, count in enumerate(counts)]
        return action_of({"do": "online", "step": "accept", "rungs": rungs}, TYPED)

    assert RUNGS_MOST == 200
    assert len(online(150, 50, 0).rungs) == 3
    with pytest.raises(ValueError, match="up to 200 texts"):
        online(150, 51)
