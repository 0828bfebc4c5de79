"""A picture of a rung is read back: what is connected in it conducts as the rung's tree says.

The picture is taken as a circuit of cells: wires conduct the ways their signs point, a contact conducts where
it is closed. Whether power gets from the left rail to the right one then has to be what series and
parallel give, whatever way the picture was laid out.
"""

import re
from functools import partial

import pytest
from hypothesis import given
from hypothesis import strategies as st
from ladder_programs import rungs
from scanrack.ladder import parse_rung
from scanrack.ladder.draw import rung_text
from scanrack.ladder.draw.ruler import SHORTEST, SYMBOLS
from scanrack.ladder.model.tree import Branch, instructions_of

UP, DOWN, LEFT, RIGHT = (0, -1), (0, 1), (-1, 0), (1, 0)
WAYS = {
    "─": (LEFT, RIGHT), "│": (UP, DOWN), "┌": (DOWN, RIGHT), "┐": (DOWN, LEFT), "└": (UP, RIGHT),
    "┘": (UP, LEFT), "├": (UP, DOWN, RIGHT), "┤": (UP, DOWN, LEFT), "┬": (LEFT, RIGHT, DOWN),
    "┴": (LEFT, RIGHT, UP), "┼": (UP, DOWN, LEFT, RIGHT), "╟": (RIGHT,), "╢": (LEFT,), "»": (LEFT, RIGHT),
}  # fmt: skip
SIGN = re.compile("┤[ /]├")
widths = st.integers(10, 60)


def against(way):
    return -way[0], -way[1]


def contacts_by_name(lines):
    """Columns of each contact's sign, by the name that stands above it."""
    found = {}
    for y, line in enumerate(lines):
        for sign in SIGN.finditer(line):
            x = sign.start()
            (name,) = (
                word.group()
                for word in re.finditer(r"C\d+", lines[y - 1])
                if word.start() <= x + 2 and word.end() > x
            )
            found[name] = (x, y)
    return found


def continued(cells):
    """Where a wire goes on, by the mark at which it breaks off: the nearest open one to the right."""
    onward, broken = {}, []
    marks = sorted((at for at, sign in cells.items() if sign == "»"), key=lambda at: (at[1], at[0]))
    for x, y in marks:
        if RIGHT in WAYS.get(cells[x - 1, y], ()):
            broken.append((x, y))
        else:
            end = min(each for each in broken if each[0] > x)
            broken.remove(end)
            onward[end] = x, y
    assert not broken
    return onward


def powered(lines, closed):
    """Whether power gets through, with the contacts in `closed` closed."""
    cells = {(x, y): sign for y, line in enumerate(lines) for x, sign in enumerate(line)}
    onward = continued(cells)
    for name, (x, y) in contacts_by_name(lines).items():
        for step in range(3):
            cells[x + step, y] = "─" if name in closed else " "
    (start,) = (at for at, sign in cells.items() if sign == "╟")
    reached, todo = set(), [start]
    while todo:
        at = todo.pop()
        if at in reached:
            continue
        reached.add(at)
        for way in WAYS.get(cells[at], ()):
            to = at[0] + way[0], at[1] + way[1]
            if against(way) in WAYS.get(cells.get(to, " "), ()):
                todo.append(to)
        if at in onward:
            todo.append(onward[at])
    return any(cells[at] == "╢" for at in reached)


def conducts(series, closed):
    """Whether a series conducts, by its tree."""
    return all(
        any(conducts(leg, closed) for leg in each.legs)
        if isinstance(each, Branch)
        else str(each.operands[0]) in closed
        for each in series
    )


@st.composite
def circuits(draw):
    """Text of a rung of contacts with names of their own, and those that are closed."""
    count = 0

    def series(depth):
        nonlocal count
        parts = []
        for _ in range(draw(st.integers(0 if depth < 3 else 1, 3))):
            if depth and draw(st.booleans()):
                parts.append(f"[{','.join(series(depth - 1) for _ in range(draw(st.integers(1, 3))))}]")
            else:
                parts.append(f"{draw(st.sampled_from(('XIC', 'XIO')))}(C{count})")
                count += 1
        return "".join(parts)

    text = f"{series(3)};"
    return text, draw(st.sets(st.sampled_from([f"C{number}" for number in range(count)]))) if count else set()


@given(circuits(), widths)
def test_the_picture_conducts_as_the_rung_does(circuit, width):
    text, closed = circuit
    rung = parse_rung(text)
    lines = rung_text(rung, width)
    assert len(contacts_by_name(lines)) == sum(1 for _ in instructions_of(rung.series))
    assert powered(lines, closed) is conducts(rung.series, closed)


@given(circuits(), st.integers(30, 60))
def test_a_rung_keeps_to_the_columns_asked_for(circuit, width):
    """Three branches in one another take 6 columns, marks 8, a leg 12: at 26 or more nothing is too wide."""
    text, _ = circuit
    assert {len(line) for line in rung_text(parse_rung(text), width)} == {width + 2}


@pytest.mark.slow
@given(rungs(), widths, st.data())
def test_nothing_is_left_out_of_a_picture(text, width, data):
    rung = parse_rung(text)
    instructions = list(instructions_of(rung.series))
    truth = data.draw(
        st.none() | st.lists(st.booleans(), min_size=len(instructions), max_size=len(instructions))
    )
    lines = rung_text(rung, width, truth)
    assert len({len(line) for line in lines}) == 1
    picture = "\n".join(lines)
    for instruction in instructions:
        for operand in map(str, instruction.operands):
            assert operand in picture or all(
                each[:SHORTEST] in picture for each in re.findall(r"\w+", operand)
            )
    boxes = re.findall("┌─*([A-Z]+)─*┐", picture)
    assert sorted(boxes) == sorted(each.name for each in instructions if each.name not in SYMBOLS)


@given(circuits(), widths)
def test_power_behind_a_rung_is_drawn_at_the_right_rail(circuit, width):
    text, closed = circuit
    rung = parse_rung(text)
    truth = []

    def play(series, live):
        for each in series:
            if isinstance(each, Branch):
                live = any(tuple(map(partial(play, live=live), each.legs)))
            else:
                live = live and str(each.operands[0]) in closed
                truth.append(live)
        return live

    end = play(rung.series, True)
    (last,) = (line for line in rung_text(rung, width, truth) if line.endswith("╢"))
    assert last[-2] in ("━┳┫┓┛┻╋┨┠┏" if end else "─┬┤┐┘┴┼├┌")
