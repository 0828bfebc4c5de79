"""The map in CONTRIBUTING.md is that of the import contracts, and its packages are in the repository."""

from __future__ import annotations

import re
import tomllib

import house
import pytest

PROJECT = tomllib.loads((house.ROOT / "pyproject.toml").read_text(encoding="utf-8"))
CONTRACTS = {
    contract["containers"][0]: [sorted(floor.split(" | ")) for floor in contract["layers"]]
    for contract in PROJECT["tool"]["importlinter"]["contracts"]
    if contract["type"] == "layers"
}
_, _, PAGE = (house.ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").partition("## The map\n")
MAP, _, _ = PAGE.partition("\n##")


def test_the_floors_of_the_map_are_those_of_the_contract() -> None:
    rows = re.findall(r"^    (\d| ) +(\w+)(/|\.py) ", MAP, re.MULTILINE)
    floors: list[list[str]] = []
    for number, room, kind in rows:
        places = [house.ROOT / f"{room}{kind}", house.ROOT / "scanrack" / f"{room}{kind}"]
        assert any(place.exists() for place in places), room
        if number != " ":
            floors.append([])
        floors[-1].append(room)
    assert [int(number) for number, *_ in rows if number != " "] == list(range(len(floors), 0, -1))
    assert [sorted(floor) for floor in floors] == CONTRACTS["scanrack"]


@pytest.mark.parametrize(
    "room", ["scanrack.jobs", "scanrack.watch", "scanrack.ladder", "scanrack.runtime", "scanrack.traces"]
)
def test_a_package_is_that_of_its_contract(room: str) -> None:
    [text] = re.findall(rf"^    {room.rpartition('.')[2]}: (.*(?:\n {{8,}}.*)*)", MAP, re.MULTILINE)
    assert [sorted(re.findall(r"\w+", floor)) for floor in text.split(">")] == CONTRACTS[room]
