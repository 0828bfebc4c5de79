"""The clients that docs/hmi-clients.md lists are those that tests try."""

from __future__ import annotations

import re

import clients_tried
from peers import PEERS, PEERS_FOLDER


def test_each_client_of_the_table_has_a_test_and_a_date() -> None:
    marks = [
        name
        for path in PEERS_FOLDER.glob("test_*.py")
        for names in re.findall(r"mark\.peer\(([^)]*)\)", path.read_text("utf-8"))
        for name in re.findall(r'"([^"]+)"', names)
    ]
    assert set(marks) == set(PEERS)
    for name, found in clients_tried.tried().items():
        assert re.search(r"\d+\.\d+", found.version), name
        assert found.tried.year >= 2026, name
