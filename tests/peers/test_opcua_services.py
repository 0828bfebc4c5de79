"""Each row of OPC UA part 4's tables of Read, Write, Browse, BrowseNext and Republish, with two clients.

The tables are 5.11.2.3/4 (Read), 5.11.4.3/4 (Write), 5.9.2.3/4 (Browse), 5.9.3.4 (BrowseNext),
5.14.5.4 (Publish), 5.14.6.3 (Republish) and 5.13.2.4 (CreateMonitoredItems) of version 1.05.
"""

from __future__ import annotations

import asyncio
import json
import os
import subprocess
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import pytest
from peers import PEERS_FOLDER, TIMEOUT_S, node_program
from ua_bench import Bench, served
from ua_services import (
    BOTH,
    BOTH_WAYS,
    FORWARD,
    INVERSE,
    NEITHER,
    SERVER,
    SOURCE,
    Services,
    Step,
    browse,
    browse_next,
    items,
    modify,
    node,
    publish,
    read,
    republish,
    start,
    subscribe,
    to,
    translate,
    value,
    write,
)

pytestmark = [pytest.mark.extra("opcua"), pytest.mark.slow]

NO_NODE, NULL, OBJECT, STRUCTURE = "Missing", "i=0", "One", "i=2256"
HAS_COMPONENT, HIERARCHICAL, ORGANIZES, OBJECTS = "i=47", "i=33", "i=35", "i=85"
DISPLAY_NAME, DESCRIPTION, NOTIFIER, ARRAY_DIMENSIONS, EXECUTABLE = 4, 5, 12, 16, 21
TOO_MANY = 10_001
DINT = "Int32"

TAGS = """TAG aScale : DINT[4] := [10,20,30,40]
TAG aBytes : USINT[3]
TAG TextList : STRING[3] := ["one","two",""]
"""

Case = tuple[list[Step], list[Any]]


def statuses(*expected: str) -> list[Step]:
    return [{"status": each} for each in expected]


def values(*expected: Any) -> list[Step]:
    return [{"status": "Good", "value": each} for each in expected]


def stamps(source: bool, server: bool) -> list[Step]:
    return [{"status": "Good", "source": source, "server": server}]


READ: Mapping[str, Case] = {
    "BadNothingToDo": ([read()], ["BadNothingToDo"]),
    "BadTooManyOperations": ([read(*[node("aDint")] * TOO_MANY)], ["BadTooManyOperations"]),
    "BadMaxAgeInvalid": ([read(node("aDint"), age=-1)], ["BadMaxAgeInvalid"]),
    "any age": ([read(node("Locked"), age=1e12)], [values(7)]),
    "BadTimestampsToReturnInvalid": ([read(node("aDint"), timestamps=4)], ["BadTimestampsToReturnInvalid"]),
    "limits that a client looks up: of reads, and continuation points": (
        [read(node("i=11705"), node("i=2735"))],
        [values(10_000, 16)],
    ),
    "BadNodeIdInvalid": ([read(node(NULL), node("Locked"))], [statuses("BadNodeIdInvalid", "Good")]),
    "BadNodeIdUnknown": ([read(node(NO_NODE), node("ns=9;s=Locked"))], [statuses(*["BadNodeIdUnknown"] * 2)]),
    "BadAttributeIdInvalid": (
        [
            read(
                node("Locked", EXECUTABLE),
                node("Locked", NOTIFIER),
                node(OBJECT),
                node("Locked", DESCRIPTION),
            )
        ],
        [statuses(*["BadAttributeIdInvalid"] * 4)],
    ),
    "BadIndexRangeInvalid": (
        [read(*(node("Grid", part=each) for each in ("a", "2:1", "1:1", "1,,2", " 1", "-1", "1:2:3")))],
        [statuses(*["BadIndexRangeInvalid"] * 7)],
    ),
    "BadIndexRangeNoData": (
        [
            read(
                *(node("Grid", part=each) for each in ("3,0", "0,4", "0", "0,0,0")),
                node("Dints", part="3000"),
                node("Locked", part="0"),
                node("Text", part="5"),
                node("Grid", DISPLAY_NAME, "0"),
            )
        ],
        [statuses(*["BadIndexRangeNoData"] * 8)],
    ),
    "parts of arrays": (
        [
            read(
                *(node("Grid", part=each) for each in ("1:2,0:1", "1,2", "2,2:9", "0:1,3")),
                *(node("aScale", part=each) for each in ("2", "1:2", "2:99")),
                node("Grid", ARRAY_DIMENSIONS, "1"),
            )
        ],
        [
            [
                {"status": "Good", "value": [5, 6, 9, 10], "dims": [2, 2]},
                {"status": "Good", "value": [7], "dims": [1, 1]},
                {"status": "Good", "value": [11, 12], "dims": [1, 2]},
                {"status": "Good", "value": [4, 8], "dims": [2, 1]},
                *values([30], [20, 30], [30, 40], [4]),
            ]
        ],
    ),
    "parts of texts": (
        [read(*(node("Text", part=each) for each in ("1:3", "0", "3:99")), node("TextList", part="0:1,1:2"))],
        [values("ell", "h", "lo", ["ne", "wo"])],
    ),
    "BadDataEncodingInvalid": (
        [read(node("Locked", encoding="Bogus"), node("Locked", DISPLAY_NAME, encoding="Default Binary"))],
        [statuses(*["BadDataEncodingInvalid"] * 2)],
    ),
    "BadDataEncodingUnsupported": (
        [read(*(node(each, encoding="Default XML") for each in ("Locked", STRUCTURE)))],
        [statuses(*["BadDataEncodingUnsupported"] * 2)],
    ),
    "the encoding that values have": ([read(node(STRUCTURE, encoding="Default Binary"))], [statuses("Good")]),
    "timestamps: source": ([read(node("Locked"), timestamps=SOURCE)], [stamps(source=True, server=False)]),
    "timestamps: server": ([read(node("Locked"), timestamps=SERVER)], [stamps(source=False, server=True)]),
    "timestamps: both": ([read(node("Locked"), timestamps=BOTH)], [stamps(source=True, server=True)]),
    "timestamps: neither": ([read(node("Locked"), timestamps=NEITHER)], [stamps(source=False, server=False)]),
    "timestamps of a part": (
        [read(node("Grid", part="1,1"), timestamps=BOTH)],
        [stamps(source=True, server=True)],
    ),
    "timestamps of another attribute": (
        [read(node("Locked", DISPLAY_NAME), timestamps=BOTH)],
        [stamps(source=False, server=True)],
    ),
    "timestamps of what is not a tag": (
        [read(node("i=2255"), timestamps=BOTH), read(node("i=2255"), timestamps=NEITHER)],
        [stamps(source=True, server=True), stamps(source=False, server=False)],
    ),
}

GRID = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]
BLOCK = [1, 2, 3, 4, -5, -6, 7, 8, -9, -10, 11, 12]


def written(step: Step, then: Step, *back: Step) -> Case:
    """Return a case whose write is read back, and undone."""
    name = step["node"]
    return [write(step), read(node(name)), *map(write, back)], [["Good"], [then], *[["Good"]] * len(back)]


WRITE: Mapping[str, Case] = {
    "BadNothingToDo": ([write()], ["BadNothingToDo"]),
    "BadTooManyOperations": ([write(*[to("aDint", value(DINT, 1))] * TOO_MANY)], ["BadTooManyOperations"]),
    "BadRequestTooLarge": (
        [write(*[to("Dints", value(DINT, [1] * 3_000))] * 100), read(node("Dints", part="0"))],
        ["BadRequestTooLarge", values([0])],
    ),
    "BadNodeIdInvalid": ([write(to(NULL, value(DINT, 1)))], [["BadNodeIdInvalid"]]),
    "BadNodeIdUnknown": ([write(to(NO_NODE, value(DINT, 1)))], [["BadNodeIdUnknown"]]),
    "BadAttributeIdInvalid": (
        [write(to("aDint", value(DINT, 1), attribute=EXECUTABLE), to(OBJECT, value(DINT, 1)))],
        [["BadAttributeIdInvalid"] * 2],
    ),
    "BadNotWritable": (
        [
            write(
                to("Locked", value(DINT, 1)),
                to("aDint", value("String", "x"), attribute=DISPLAY_NAME),
                to("i=2256", value(DINT, 1)),
                to("Local:1:I.Data", value("Int16", [1]), part="0"),
            )
        ],
        [["BadNotWritable"] * 4],
    ),
    "BadIndexRangeInvalid": (
        [write(*(to("Dints", value(DINT, [1]), part=each) for each in ("a", "1:1", "2:1", "1,", "-1")))],
        [["BadIndexRangeInvalid"] * 5],
    ),
    "BadIndexRangeNoData": (
        [
            write(
                to("Dints", value(DINT, [1]), part="3000"),
                to("Dints", value(DINT, [1, 2]), part="2999:3000"),
                to("Dints", value(DINT, [1]), part="0,0"),
                to("Grid", value("Int16", [1]), part="0"),
                to("Grid", value("Int16", [1], [1, 1]), part="3,0"),
                to("aDint", value(DINT, 1), part="0"),
                to("Text", value("String", "xy"), part="4:5"),
            )
        ],
        [["BadIndexRangeNoData"] * 7],
    ),
    "BadIndexRangeDataMismatch": (
        [
            write(
                to("Dints", value(DINT, [1, 2]), part="5"),
                to("Dints", value(DINT, [1, 2]), part="5:7"),
                to("Grid", value("Int16", [1, 2], [1, 2]), part="1:2,0:1"),
                to("Text", value("String", "xyz"), part="0:1"),
            )
        ],
        [["BadIndexRangeDataMismatch"] * 4],
    ),
    "BadWriteNotSupported": (
        [
            write(
                to("aDint", value(DINT, 1), status="BadInternalError"),
                to("aDint", value(DINT, 1), status="Uncertain"),
                to("aDint", value(DINT, 1), server=True),
                to("aDint", None, source=True),
            )
        ],
        [["BadWriteNotSupported"] * 4],
    ),
    "BadTypeMismatch": (
        [
            write(
                to("aDint", value("Int16", 1)),
                to("aDint", value("Double", 1.0)),
                to("aDint", value(DINT, [1])),
                to("aDint", None),
                to("Text", value(DINT, 1)),
                to("Dints", value(DINT, 1)),
                to("Dints", value("Int16", [1]), part="5"),
                to("Grid", value("Int16", GRID)),
                to("Dints", value(DINT, [1, 2], [1, 2]), part="0:1"),
            )
        ],
        [["BadTypeMismatch"] * 9],
    ),
    "BadOutOfRange": (
        [
            write(
                to("Text", value("String", "x" * 83)),
                to("Text", value("String", "\u20ac")),
                to("Dints", value(DINT, [1, 2])),
            )
        ],
        [["BadOutOfRange"] * 3],
    ),
    "some of several": (
        [
            write(to("Locked", value(DINT, 1)), to("aDint", value(DINT, 5)), to(NO_NODE, value(DINT, 1))),
            read(node("aDint"), node("Locked")),
        ],
        [["BadNotWritable", "Good", "BadNodeIdUnknown"], values(5, 7)],
    ),
    "a value with a source timestamp, which asyncua sends": written(
        to("aDint", value(DINT, 6), source=True), {"status": "Good", "value": 6}
    ),
    "one element of 3,000": (
        [
            write(to("Dints", value(DINT, [-150]), part="150")),
            read(node("Dints", part="149:151")),
            write(to("Dints", value(DINT, [0]), part="150")),
        ],
        [["Good"], values([0, -150, 0]), ["Good"]],
    ),
    "one element without its array": (
        [
            write(to("Dints", value(DINT, -151), part="151")),
            read(node("Dints", part="150:152")),
            write(to("Dints", value(DINT, 0), part="151")),
        ],
        [["Good"], values([0, -151, 0]), ["Good"]],
    ),
    "elements beside each other": (
        [
            write(to("Dints", value(DINT, [1, 2, 3]), part="2997:2999")),
            read(node("Dints", part="2996:2999")),
            write(to("Dints", value(DINT, [0, 0, 0]), part="2997:2999")),
        ],
        [["Good"], values([0, 1, 2, 3]), ["Good"]],
    ),
    "a block": written(
        to("Grid", value("Int16", [-5, -6, -9, -10], [2, 2]), part="1:2,0:1"),
        {"status": "Good", "value": BLOCK, "dims": [3, 4]},
        to("Grid", value("Int16", [5, 6, 9, 10], [2, 2]), part="1:2,0:1"),
    ),
    "bits": (
        [
            write(to("Flags", value("Boolean", [True] * 9), part="6:14")),
            read(node("Flags", part="4:16")),
            write(to("Flags", value("Boolean", [False] * 9), part="6:14")),
            read(node("Flags", part="0:63")),
        ],
        [["Good"], values([False, False, *[True] * 9, False, False]), ["Good"], values([False] * 64)],
    ),
    "characters": (
        [
            write(
                to("Text", value("String", "EL"), part="1:2"),
                to("TextList", value("String", ["ONE"]), part="0"),
            ),
            read(node("Text"), node("TextList")),
            write(to("TextList", value("String", ["n", "W"]), part="0:1,1:1") | {"range": "0:1,1"}),
            read(node("TextList")),
            write(
                to("Text", value("String", "el"), part="1:2"),
                to("TextList", value("String", ["one", "two"]), part="0:1"),
            ),
        ],
        [
            ["Good"] * 2,
            values("hELlo", ["ONE", "two", ""]),
            ["Good"],
            values(["OnE", "tWo", ""]),
            ["Good"] * 2,
        ],
    ),
    "bytes of an array of Byte": (
        [
            write(to("aBytes", value("ByteString", [1, 2, 3]))),
            read(node("aBytes")),
            write(to("aBytes", value("ByteString", [9]), part="1")),
            read(node("aBytes", part="0:2")),
        ],
        [["Good"], values([1, 2, 3]), ["Good"], values([1, 9, 3])],
    ),
}

TAG_NAMES = ["aBool", "aSint", "anInt", "aDint"]
GRID_NAMES = [f"[{row},{column}]" for row in range(3) for column in range(4)]


def browsed(names: Sequence[str], *, more: bool = False) -> list[Step]:
    return [{"status": "Good", "names": list(names), "more": more}]


BROWSE: Mapping[str, Case] = {
    "BadNothingToDo": ([browse()], ["BadNothingToDo"]),
    "BadTooManyOperations": ([browse(*[start("aDint")] * TOO_MANY)], ["BadTooManyOperations"]),
    "BadViewIdUnknown": (
        [browse(start("Grid"), view="ns=2;s=NoView"), browse(start("Grid"), view=OBJECTS)],
        ["BadViewIdUnknown"] * 2,
    ),
    "BadNodeIdInvalid": ([browse(start(NULL))], [statuses("BadNodeIdInvalid")]),
    "BadNodeIdUnknown": ([browse(start(NO_NODE), start("Hosts"))], [statuses("BadNodeIdUnknown", "Good")]),
    "BadBrowseDirectionInvalid": ([browse(start("Grid", 3))], [statuses("BadBrowseDirectionInvalid")]),
    "BadReferenceTypeIdInvalid": (
        [browse(*(start("Grid", type=each) for each in ("i=99999", OBJECTS, "Grid")))],
        [statuses(*["BadReferenceTypeIdInvalid"] * 3)],
    ),
    "BadNoContinuationPoints": (
        [browse(*[start("Grid")] * 18, most=1)],
        [statuses(*["Good"] * 16, *["BadNoContinuationPoints"] * 2)],
    ),
    "directions": (
        [browse(*(start("Grid", each, type=HIERARCHICAL) for each in (FORWARD, INVERSE, BOTH_WAYS)))],
        [[*browsed(GRID_NAMES), *browsed(["bench"]), *browsed(["bench", *GRID_NAMES])]],
    ),
    "types of references": (
        [
            browse(
                start("Hosts", type=HAS_COMPONENT),
                start("Hosts", type=HIERARCHICAL),
                start("Hosts", type=HIERARCHICAL, subtypes=False),
                start("Hosts", type=ORGANIZES),
                start("Hosts", type="i=40"),
            )
        ],
        [
            [
                *browsed(["Go", "Stop", "Level"]) * 2,
                *browsed([]) * 2,
                *browsed(["BaseObjectType"]),
            ]
        ],
    ),
    "classes of nodes": (
        [browse(*(start("One", BOTH_WAYS, classes=each) for each in (1, 2, 8, 3)))],
        [
            [
                *browsed(["bench", "Steps"]),
                *browsed(["Id", "Flag", "Name", "Bits", "Total"]),
                *browsed(["BaseObjectType"]),
                *browsed(["bench", "Id", "Flag", "Steps", "Name", "Bits", "Total"]),
            ]
        ],
    ),
    "fields of references": (
        [browse(start("Hosts", fields=0), start("Hosts", type=HAS_COMPONENT, fields=40))],
        [
            [
                {"status": "Good", "names": [None] * 4, "types": [0] * 4},
                {"status": "Good", "names": ["Go", "Stop", "Level"], "types": [63] * 3},
            ]
        ],
    ),
}

BROWSE_PATHS: Mapping[str, Case] = {
    "BadNothingToDo": ([translate(), translate(("Many", []))], ["BadNothingToDo", [["BadNothingToDo"]]]),
    "BadTooManyOperations": ([translate(*[("Many", ["[0]"])] * TOO_MANY)], ["BadTooManyOperations"]),
    "BadNodeIdInvalid": ([translate((NULL, ["x"]))], [[["BadNodeIdInvalid"]]]),
    "BadNodeIdUnknown": ([translate((NO_NODE, ["x"]))], [[["BadNodeIdUnknown"]]]),
    "BadBrowseNameInvalid": ([translate(("Many", ["[0]", ""]))], [[["BadBrowseNameInvalid"]]]),
    "BadNoMatch": ([translate(("Many", ["[0]", "No"]))], [[["BadNoMatch"]]]),
    "a path": ([translate(("Many", ["[0]", "Id"]))], [[["Good", "Many[0].Id"]]]),
    "a path that leads back": (
        [translate(("Many[0].Id", ["[0]", "Many"]), inverse=True)],
        [[["Good", "Many"]]],
    ),
}

NEXT: Mapping[str, Case] = {
    "BadNothingToDo": ([browse_next()], ["BadNothingToDo"]),
    "BadTooManyOperations": ([browse_next(*["none"] * TOO_MANY)], ["BadTooManyOperations"]),
    "BadContinuationPointInvalid": ([browse_next("none")], [statuses("BadContinuationPointInvalid")]),
    "in pieces": (
        [
            browse(start("Grid", type=HAS_COMPONENT), start("Hosts", type=HAS_COMPONENT), most=5),
            browse_next("0.0"),
            browse_next("1.0"),
            browse_next("1.0", "0.0"),
        ],
        [
            [*browsed(GRID_NAMES[:5], more=True), *browsed(["Go", "Stop", "Level"])],
            browsed(GRID_NAMES[5:10], more=True),
            browsed(GRID_NAMES[10:]),
            statuses(*["BadContinuationPointInvalid"] * 2),
        ],
    ),
    "no point behind the last one": (
        [
            browse(start("Grid", type=HAS_COMPONENT), most=12),
            browse(start("Grid", type=HAS_COMPONENT), most=11),
        ],
        [browsed(GRID_NAMES), browsed(GRID_NAMES[:11], more=True)],
    ),
    "one at a time": (
        [browse(start("Hosts", type=HAS_COMPONENT), most=1), *map(browse_next, ("0.0", "1.0", "2.0"))],
        [
            browsed(["Go"], more=True),
            browsed(["Stop"], more=True),
            browsed(["Level"]),
            statuses("BadContinuationPointInvalid"),
        ],
    ),
    "released": (
        [browse(start("Grid"), most=5), browse_next("0.0", "none", release=True), browse_next("0.0")],
        [[{"status": "Good", "more": True}], [], statuses("BadContinuationPointInvalid")],
    ),
    "the oldest is released for a new request": (
        [
            browse(*[start("Grid")] * 16, most=1),
            browse(start("Hosts", type=HAS_COMPONENT), most=1),
            browse_next("0.0"),
            browse_next("0.1"),
            browse_next("1.0"),
        ],
        [
            [{"status": "Good", "more": True}] * 16,
            browsed(["Go"], more=True),
            statuses("BadContinuationPointInvalid"),
            statuses("Good"),
            browsed(["Stop"], more=True),
        ],
    ),
}

CHANGED = {"status": "Good", "value": 7}
SUBSCRIBE, SUBSCRIBED = subscribe(), [1_000, 10]
FIRST = [SUBSCRIBE, items(node("Locked"))]
MADE: list[Any] = [SUBSCRIBED, ["Good"]]

SUBSCRIPTIONS: Mapping[str, Case] = {
    "Republish: BadSubscriptionIdInvalid": ([republish(1, other=True)], ["BadSubscriptionIdInvalid"]),
    "Republish: BadSubscriptionIdInvalid beside another one": (
        [SUBSCRIBE, republish(1, other=True)],
        [SUBSCRIBED, "BadSubscriptionIdInvalid"],
    ),
    "Republish: BadMessageNotAvailable": (
        [SUBSCRIBE, republish(1), republish(0)],
        [SUBSCRIBED, *["BadMessageNotAvailable"] * 2],
    ),
    "a message is there until it is acknowledged": (
        [*FIRST, publish(), republish(1), republish(1), republish(2), publish(1), republish(1)],
        [
            *MADE,
            [[], CHANGED],
            [CHANGED],
            [CHANGED],
            "BadMessageNotAvailable",
            [["Good"]],
            "BadMessageNotAvailable",
        ],
    ),
    "Publish: BadNoSubscription": ([publish()], ["BadNoSubscription"]),
    "Publish: BadSequenceNumberUnknown": (
        [*FIRST, publish(), publish(1, 4)],
        [*MADE, [[], CHANGED], [["Good", "BadSequenceNumberUnknown"]]],
    ),
    "Publish: BadSubscriptionIdInvalid": (
        [*FIRST, publish(5, other=True)],
        [*MADE, [["BadSubscriptionIdInvalid"], CHANGED]],
    ),
    "a subscription lives as long as three messages to keep it alive take": (
        [subscribe(5, 10), subscribe(0, 0)],
        [[30, 10], [15_000, 5_000]],
    ),
    "items: BadFilterNotAllowed": (
        [SUBSCRIBE, items(node("Text"), node("aBool"), node("Locked", DISPLAY_NAME), deadband=(1, 2.0))],
        [SUBSCRIBED, ["BadFilterNotAllowed"] * 3],
    ),
    "items: BadMonitoredItemFilterUnsupported": (
        [SUBSCRIBE, items(node("Grid"), deadband=(1, 2.0)), items(node("Locked"), deadband=(2, 2.0))],
        [SUBSCRIBED, *[["BadMonitoredItemFilterUnsupported"]] * 2],
    ),
    "items: a deadband": (
        [SUBSCRIBE, items(node("Locked"), deadband=(1, 2.0)), publish()],
        [SUBSCRIBED, ["Good"], [[], CHANGED]],
    ),
    "items: BadEventFilterInvalid": (
        [SUBSCRIBE, items(node("i=2253", NOTIFIER))],
        [SUBSCRIBED, ["BadEventFilterInvalid"]],
    ),
    "changed items: what is refused": (
        [*FIRST, modify(), modify(0, timestamps=4), modify(0, other=True), modify(-1, 0)],
        [
            *MADE,
            "BadNothingToDo",
            "BadTimestampsToReturnInvalid",
            "BadSubscriptionIdInvalid",
            ["BadMonitoredItemIdInvalid", "Good"],
        ],
    ),
    "changed items: timestamps": (
        [
            SUBSCRIBE,
            items(node("aDint")),
            publish(),
            modify(0, timestamps=SOURCE),
            write(to("aDint", value(DINT, 41))),
            publish(1),
        ],
        [
            *MADE,
            [[], {"status": "Good", "source": False}],
            ["Good"],
            ["Good"],
            [["Good"], {"status": "Good", "value": 41, "source": True, "server": False}],
        ],
    ),
    "items: only the part that is named is watched": (
        [
            SUBSCRIBE,
            items(node("aScale", part="1")),
            publish(),
            write(to("aScale", value(DINT, [11]), part="0")),
            write(to("aScale", value(DINT, [21]), part="1")),
            publish(1),
            write(to("aScale", value(DINT, [10, 20]), part="0:1")),
        ],
        [*MADE, [[], *values([20])], ["Good"], ["Good"], [["Good"], *values([21])], ["Good"]],
    ),
    "items: BadNothingToDo": ([SUBSCRIBE, items()], [SUBSCRIBED, "BadNothingToDo"]),
    "items: BadSubscriptionIdInvalid": (
        [SUBSCRIBE, items(node("Locked"), other=True)],
        [SUBSCRIBED, "BadSubscriptionIdInvalid"],
    ),
    "items: BadTimestampsToReturnInvalid": (
        [SUBSCRIBE, items(node("Locked"), timestamps=4)],
        [SUBSCRIBED, "BadTimestampsToReturnInvalid"],
    ),
    "items: what is refused": (
        [
            SUBSCRIBE,
            items(
                node(NULL),
                node(NO_NODE),
                node("Locked", EXECUTABLE),
                node("Grid", part="1:1"),
                node("Locked", encoding="Bogus"),
                node("Locked", encoding="Default XML"),
                node("Locked"),
            ),
            publish(),
        ],
        [
            SUBSCRIBED,
            [
                "BadNodeIdInvalid",
                "BadNodeIdUnknown",
                "BadAttributeIdInvalid",
                "BadIndexRangeInvalid",
                "BadDataEncodingInvalid",
                "BadDataEncodingUnsupported",
                "Good",
            ],
            [[], CHANGED],
        ],
    ),
    "items: parts": (
        [
            SUBSCRIBE,
            items(node("aScale", part="1:2"), node("Text", part="0:1"), node("aScale", part="9")),
            publish(),
        ],
        [
            SUBSCRIBED,
            ["Good"] * 3,
            [[], *values([20, 30], "he"), {"status": "BadIndexRangeNoData"}],
        ],
    ),
    **{
        f"items: timestamps {name}": (
            [SUBSCRIBE, items(node("Locked"), timestamps=each), publish()],
            [SUBSCRIBED, ["Good"], [[], {"status": "Good", "source": source, "server": server}]],
        )
        for name, each, source, server in (
            ("source", SOURCE, True, False),
            ("server", SERVER, False, True),
            ("both", BOTH, True, True),
            ("neither", NEITHER, False, False),
        )
    },
}

CASES: Mapping[str, Case] = {
    f"{service}: {name}": case
    for service, cases in (
        ("Read", READ),
        ("Write", WRITE),
        ("Browse", BROWSE),
        ("TranslateBrowsePaths", BROWSE_PATHS),
        ("BrowseNext", NEXT),
        ("subscription", SUBSCRIPTIONS),
    )
    for name, case in cases.items()
}


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    with served(tmp_path_factory.mktemp("services"), tags=TAGS) as bench:
        yield bench


def with_asyncua(bench: Bench) -> list[list[Any]]:
    """Return what all cases bring; each has a session of its own."""

    async def work() -> list[list[Any]]:
        found = []
        for steps, _ in CASES.values():
            async with bench.client() as client:
                found.append(await Services(client).run(steps))
        return found

    return asyncio.run(work())


def with_node_opcua(bench: Bench) -> list[list[Any]]:
    program = node_program("node-opcua-client")
    url = f"opc.tcp://127.0.0.1:{bench.service.port}/scanrack"
    done = subprocess.run(
        [program, PEERS_FOLDER / "services_ua.cjs", url],
        input=json.dumps([steps for steps, _ in CASES.values()]),
        capture_output=True,
        encoding="utf-8",
        timeout=TIMEOUT_S,
        env=os.environ,
    )
    assert done.returncode == 0, done.stderr + done.stdout
    found: list[list[Any]] = json.loads(done.stdout.splitlines()[-1])
    return found


def like(found: Any, expected: Any) -> Any:
    """Return what came back, of a result only the fields that are expected."""
    if isinstance(expected, dict) and isinstance(found, dict):
        return {key: found.get(key) for key in expected}
    if isinstance(expected, list) and isinstance(found, list) and len(found) == len(expected):
        return [like(each, then) for each, then in zip(found, expected, strict=True)]
    return found


CLIENTS: Mapping[str, Callable[[Bench], list[list[Any]]]] = {
    "asyncua": with_asyncua,
    "node-opcua-client": with_node_opcua,
}


@pytest.fixture(
    scope="module",
    params=[pytest.param(each, marks=pytest.mark.peer(name), id=name) for name, each in CLIENTS.items()],
)
def found(request: pytest.FixtureRequest, bench: Bench) -> dict[str, list[Any]]:
    return dict(zip(CASES, request.param(bench), strict=True))


@pytest.mark.parametrize("name", CASES)
def test_each_row(found: dict[str, list[Any]], name: str) -> None:
    _, expected = CASES[name]
    assert like(found[name], expected) == expected
