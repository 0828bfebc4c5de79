"""Random edits of a controller: the comparison names exactly those.

The oracle is the list of edits: it knows nothing of documents. Names are new for each edit, so that no two
parts of the controller are alike.
"""

import tempfile
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from amounts import amount
from hypothesis import given, settings
from hypothesis import strategies as st
from l5x_files import data_type, document, ladder, member, module, program, rung, tag, task, value
from scanrack.rockwell.diff import compare_exports


@dataclass
class Plant:
    """A controller that edits change."""

    routines: dict[str, list[tuple[str, str]]]  # rungs by routine: text and comment
    tags: dict[str, int]
    rate: int = 10
    slot: int = 3
    members: list[str] = field(default_factory=lambda: ["Time", "Speed"])
    day: str = "Mon"

    def text(self) -> str:
        routines = [
            ladder(name, *(rung(text, number=n, comment=said) for n, (text, said) in enumerate(rungs)))
            for name, rungs in self.routines.items()
        ]
        written = document(
            types=[data_type("Recipe", *(member(each, "DINT") for each in self.members))],
            modules=[module("Inputs", self.slot)],
            tags=[tag(name, "DINT", data=value("DINT", number)) for name, number in self.tags.items()],
            programs=[program("P", *routines)],
            tasks=[task("T", "P", kind="PERIODIC", rate=self.rate)],
        )
        return written.replace("TargetName", f'ExportDate="{self.day}" TargetName')


def plant(rungs: int) -> Plant:
    routines = {f"R{r}": [(text_of(f"{r}_{n}"), f"rung {n}") for n in range(rungs)] for r in range(3)}
    return Plant(routines, {f"Used0_{n}": n for n in range(4)} | {f"Spare{n}": n for n in range(5)})


def text_of(ident: str) -> str:
    return f"XIC(A{ident})XIO(B{ident})TON(C{ident},?,?)EQU(Used{ident},7)OTE(D{ident});"


EDITS = (
    "change",
    "delete",
    "insert",
    "comment",
    "tag",
    "drop",
    "new",
    "rename",
    "rate",
    "slot",
    "member",
    "day",
)


class Editor:
    """Applies edits; `expected` are the differences that they make."""

    def __init__(self, edited: Plant, draw) -> None:
        self.plant, self._draw = edited, draw
        self.expected: Counter[tuple[str, str, str]] = Counter()
        self._free = {name: list(rungs) for name, rungs in edited.routines.items()}
        self._count = 0

    def apply(self, edit: str) -> None:
        self._count += 1
        getattr(self, edit)(f"New{self._count}")

    def _rung(self):
        """Choose a rung that no edit has changed; return its routine and place, or None."""
        free = [(name, each) for name, rungs in self._free.items() for each in rungs]
        if not free:
            return None
        name, chosen = self._draw(st.sampled_from(free))
        self._free[name].remove(chosen)
        return name, self.plant.routines[name].index(chosen)

    def _expect(self, kind: str, what: str, content: str) -> None:
        self.expected[kind, what, content] += 1

    def change(self, new: str) -> None:
        found = self._rung()
        if found:
            rungs, at = self.plant.routines[found[0]], found[1]
            text, said = rungs[at]
            letter = self._draw(st.sampled_from("ABCD"))
            rungs[at] = (text.replace(f"({letter}", f"({new}"), said)
            self._expect("changed", "rung", rungs[at][0])

    def delete(self, _new: str) -> None:
        found = self._rung()
        if found:
            text, _ = self.plant.routines[found[0]].pop(found[1])
            self._expect("removed", "rung", text)

    def insert(self, new: str) -> None:
        rungs = self.plant.routines[self._draw(st.sampled_from(sorted(self.plant.routines)))]
        text = text_of(new)
        rungs.insert(self._draw(st.integers(0, len(rungs))), (text, new))
        self._expect("added", "rung", text)

    def comment(self, new: str) -> None:
        found = self._rung()
        if found:
            rungs, at = self.plant.routines[found[0]], found[1]
            rungs[at] = (rungs[at][0], new)
            self._expect("changed", "comment", new)

    def tag(self, _new: str) -> None:
        name = next((each for each in self.plant.tags if each.startswith("Spare")), None)
        if name and self.plant.tags[name] < 100:
            self.plant.tags[name] += 100
            self._expect("changed", "tag", name)

    def drop(self, _new: str) -> None:
        names = [
            each for each, number in self.plant.tags.items() if each.startswith("Spare") and number < 100
        ]
        if names:
            del self.plant.tags[names[-1]]
            self._expect("removed", "tag", names[-1])

    def new(self, new: str) -> None:
        self.plant.tags[f"Fresh{new}"] = 1
        self._expect("added", "tag", f"Fresh{new}")

    def rename(self, new: str) -> None:
        """Rename the tag of a rung that no edit has changed."""
        rungs = self._free["R0"]
        used = [(text, said) for text, said in rungs if any(f"({name}," in text for name in self.plant.tags)]
        if used and not self.expected["renamed", "tag", ""]:
            text, said = used[0]
            rungs.remove(used[0])
            name = next(each for each in self.plant.tags if f"({each}," in text)
            at = self.plant.routines["R0"].index((text, said))
            self.plant.routines["R0"][at] = (text.replace(f"({name},", f"(Named{new},"), said)
            self.plant.tags = {
                f"Named{new}" if each == name else each: n for each, n in self.plant.tags.items()
            }
            self._expect("renamed", "tag", f"Named{new}")

    def rate(self, _new: str) -> None:
        self.plant.rate = 20
        self.expected["changed", "task", "T"] = 1

    def slot(self, _new: str) -> None:
        self.plant.slot = 4
        self.expected["changed", "module", "Inputs"] = 1

    def member(self, _new: str) -> None:
        self.plant.members = ["Time", "Speed", "Dwell"]
        self.expected["changed", "data type", "Recipe"] = 1

    def day(self, _new: str) -> None:
        self.plant.day = "Tue"


def compare(old: str, new: str):
    with tempfile.TemporaryDirectory() as folder:
        files = Path(folder) / "old.L5X", Path(folder) / "new.L5X"
        for file, text in zip(files, (old, new), strict=True):
            file.write_text(text, encoding="utf-8")
        return compare_exports(*files)


def content(difference) -> str:
    if difference.noun in ("rung", "comment"):
        return difference.new_text or difference.old_text
    return difference.name


@settings(max_examples=amount(25), deadline=None)
@given(st.data())
def test_a_comparison_names_exactly_the_edits(data):
    edited = plant(data.draw(st.integers(1, 12)))
    old = edited.text()
    editor = Editor(edited, data.draw)
    for edit in data.draw(st.lists(st.sampled_from(EDITS), max_size=12)):
        editor.apply(edit)
    found = compare(old, edited.text())
    named = Counter((each.kind, each.noun, content(each)) for each in found.differences)
    assert named == +editor.expected
    assert bool(found.apart) == (edited.day != "Mon")


@settings(max_examples=amount(25), deadline=None)
@given(st.permutations(range(9)))
def test_moved_rungs_are_as_few_as_can_be_and_the_rest_keeps_its_order(order):
    rungs = [(text_of(str(n)), "") for n in range(9)]
    before, after = Plant({"R": rungs}, {}), Plant({"R": [rungs[n] for n in order]}, {})
    found = compare(before.text(), after.text()).differences
    assert {each.kind for each in found} <= {"moved"}
    moved = {each.new_text for each in found}
    kept = [n for n in order if rungs[n][0] not in moved]
    assert kept == sorted(kept)
    assert len(kept) == longest_increase(order)


def longest_increase(order) -> int:
    """The length of the longest ascending part, by all that end at each place."""
    ends: list[int] = []
    for at, number in enumerate(order):
        ends.append(1 + max((ends[i] for i in range(at) if order[i] < number), default=0))
    return max(ends)
