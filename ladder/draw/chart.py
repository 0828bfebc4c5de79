"""A sequential function chart as SVG that a page updates; `model.chart_layout` places its elements.

    <g class="element step" data-at="Main.3" data-lit="Fill.X"> ... </g>

The page sets a group's `data-value` from the tag in `data-lit`, which is on if a step is active, an action is
on, or a transition is true. Units are pixels. Widths depend on the text; a character is 8 pixels wide.
"""

from __future__ import annotations

from collections.abc import Iterator

from ..model.chart import Action, Chart, ChartStep, Qualifier, Transition
from ..model.chart_layout import ChartLayout, layout_of
from ..model.statements import block_lines
from ..model.tree import Address, MemberStep
from .markup import CELL, LivePicture, TagName, attribute, cut, live_picture, plain

STEP_HIGH, LINE, GAP, PAD = 44, 18, 26, 10  # pixels: height of a step, height of a line, gap of rows, padding
LEAST = 104  # minimum width of a step's box, in pixels
MOST_SHOWN = 6  # maximum lines of an action's body
MOST_WIDE = 44  # maximum characters of a line
EDGE = 14


def live_chart(chart: Chart, ident: str, name_of: TagName = str) -> LivePicture:
    """Draw a chart for a page.

    Args:
        ident: prefix of its element ids: `Main` for routine Main.
        name_of: returns the tag of an address.
    """
    return _Picture(chart, ident, name_of).drawn()


def action_lines(action: Action) -> list[str]:
    """Return the lines shown in an action's box: its name, then its body."""
    head = action.name if action.preset is None else f"{action.name}  PRE := {action.preset}"
    if action.body is None:
        return [cut(head, MOST_WIDE)]
    body = [line for line in block_lines(action.body) if line]
    omitted = [f"… {len(body) - MOST_SHOWN} more lines"] if len(body) > MOST_SHOWN else []
    return [*(cut(line, MOST_WIDE) for line in (head, *body[:MOST_SHOWN])), *omitted]


def _actions_width(step: ChartStep) -> int:
    """Return the width of the longest line of a step's actions; 0 if it has none."""
    longest = max((len(line) for action in step.actions for line in action_lines(action)), default=0)
    return longest * CELL


class _Picture:
    """Draws one chart; a page finds its elements by `ident` and their numbers."""

    def __init__(self, chart: Chart, ident: str, name_of: TagName) -> None:
        self._chart, self._ident, self._name_of = chart, ident, name_of
        self._cells: ChartLayout = layout_of(chart)
        self._names: dict[str, None] = {}  # tags that it shows
        self._lefts = self._columns()
        self._tops = self._rows()
        self._svg: list[str] = []

    def drawn(self) -> LivePicture:
        """Draw wires first, then the elements over them."""
        for number, transition in enumerate(self._chart.transitions):
            self._wires(number, transition)
        for step in self._chart.steps:
            self._step(step)
        for number, transition in enumerate(self._chart.transitions):
            self._transition(number, transition)
        width, height = self._lefts[-1] + EDGE, self._tops[-1] + EDGE
        label = f"Chart {self._ident}"
        return live_picture("rung chart", label, self._svg, self._names, width, height)

    # --- measures

    def _box_width(self, step: ChartStep) -> int:
        return max(LEAST, len(step.name) * CELL + 2 * PAD + 8)

    def _width(self, step: ChartStep) -> int:
        """Return the width of a step including its actions."""
        return self._box_width(step) + (_actions_width(step) + 4 * PAD + 40 if step.actions else 0)

    def _height(self, step: ChartStep) -> int:
        return max(STEP_HIGH, sum(len(action_lines(action)) * LINE + 8 for action in step.actions))

    def _columns(self) -> list[int]:
        """Return the left edges of the columns and the right edge of the last one, in pixels."""
        widths = [LEAST] * self._cells.columns
        for step in self._chart.steps:
            column, _ = self._cells.steps[step.name.upper()]
            widths[column] = max(widths[column], self._width(step))
        for (column, _), transition in zip(self._cells.transitions, self._chart.transitions, strict=True):
            text_width = len(cut(f"{transition.name}  {transition.condition}", MOST_WIDE)) * CELL
            widths[column] = max(widths[column], LEAST // 2 + 2 * PAD + text_width)
        lefts = [EDGE]
        for width in widths:
            lefts.append(lefts[-1] + width + GAP)
        return lefts

    def _rows(self) -> list[int]:
        """Return the top edges of the rows and the bottom edge of the last one, in pixels."""
        heights = [LINE + 4] * self._cells.rows
        for step in self._chart.steps:
            _, row = self._cells.steps[step.name.upper()]
            heights[row] = max(heights[row], self._height(step))
        for number, target in self._cells.jumps:
            _, row = self._cells.transitions[number]
            heights[row] = max(heights[row], LINE + 4 + (LINE if target else 0))
        tops = [EDGE]
        for height in heights:
            tops.append(tops[-1] + height + GAP)
        return tops

    def _middle(self, column: int) -> int:
        return self._lefts[column] + LEAST // 2

    # --- elements

    def _tag(self, name: str, *members: str) -> str:
        """Return the tag of a name or member and add it to the picture's tags; "" if there is none."""
        tag = self._name_of(Address(name, tuple(map(MemberStep, members))))
        if tag is not None:
            self._names[tag] = None
        return tag or ""

    def _group(self, kind: str, number: int, lit: str, title: str, inside: str) -> None:
        """Add an element's group: `number` is its place in the routine, `lit` the tag that lights it."""
        attributes = f"data-at={attribute(f'{self._ident}.{number}')} data-lit={attribute(lit)}"
        self._svg.append(f'<g class="element {kind}" {attributes}><title>{plain(title)}</title>{inside}</g>')

    def _step(self, step: ChartStep) -> None:
        """Draw a step and its actions; an initial step has a second frame, a stop has a line."""
        column, row = self._cells.steps[step.name.upper()]
        x, y, width = self._lefts[column], self._tops[row], self._box_width(step)
        kind = "stop" if step.stop else "step"
        inside = f'<rect class="box" x="{x}" y="{y}" width="{width}" height="{STEP_HIGH}" rx="4"/>'
        if step.initial:
            size = f'width="{width - 8}" height="{STEP_HIGH - 8}"'
            inside += f'<rect class="sign" x="{x + 4}" y="{y + 4}" {size} rx="2"/>'
        if step.stop:
            inside += f'<path class="sign" d="M{x} {y + STEP_HIGH - 5}h{width}"/>'
        inside += _text(x + width // 2, y + 19, step.name, "name middle")
        if not step.stop:
            inside += self._value(step.name, "T", x + width // 2, y + 35, "middle")
        head = f"{step.head}: {', '.join(map(str, dict(step.presets)))}" if step.presets else step.head
        self._group(kind, step.number, self._tag(step.name, "X"), head, inside)
        self._actions(step, x + width, y)

    def _actions(self, step: ChartStep, x: int, y: int) -> None:
        """Draw the actions of a step one below another, beginning at a point; each has its qualifier."""
        width = _actions_width(step) + 2 * PAD
        if step.actions:
            self._wire(f"M{x} {y + STEP_HIGH // 2}h16")
        for action in step.actions:
            lines = action_lines(action)
            height, left = len(lines) * LINE + 8, x + 16
            inside = f'<rect class="box" x="{left}" y="{y}" width="{width + 40}" height="{height}" rx="2"/>'
            inside += f'<path class="sign" d="M{left + 36} {y}v{height}"/>'
            inside += _text(left + 18, y + 17, action.qualifier.value, "heading middle")
            for line_number, line in enumerate(lines):
                kind = "caption" if line_number else "name"
                inside += _text(left + 36 + PAD, y + 17 + line_number * LINE, line, kind)
            title = f"step {step.name}: {action.head}"
            resets = action.qualifier is Qualifier.R  # then it ends the action, so its step lights it
            lit = self._tag(step.name, "X") if resets else self._tag(action.name, "A")
            self._group("action", action.number, lit, title, inside)
            y += height

    def _transition(self, number: int, transition: Transition) -> None:
        """Draw a transition: its bar, name and condition, and the names of steps that no wire leads to."""
        column, row = self._cells.transitions[number]
        x, y = self._middle(column), self._tops[row] + 11
        inside = f'<path class="sign bar" d="M{x - 18} {y}h36"/>'
        inside += _text(x + 26, y + 5, transition.name, "name")
        # the name and the condition are cut together, as in `_columns`
        condition = cut(f"{transition.name}  {transition.condition}", MOST_WIDE)[len(transition.name) + 2 :]
        inside += _text(x + 26 + (len(transition.name) + 2) * CELL, y + 5, condition, "caption")
        jumps = [name for name in transition.targets if (number, name.upper()) in self._cells.jumps]
        if jumps:
            inside += f'<path class="sign" d="M{x} {y + 6}v14m-5 -6l5 7l5 -7"/>'
            inside += _text(x + 12, y + 24, f"to {', '.join(jumps)}", "caption")
        title = f"{transition.head}: {transition.condition}"
        self._group("transition", transition.number, self._tag(transition.name), title, inside)

    def _value(self, name: str, member: str, x: int, y: int, anchor: str) -> str:
        """Return an empty text element, which the page fills with a member's value; "" without a tag."""
        tag = self._tag(name, member)
        return (
            f'<text class="value {anchor}" data-value-of={attribute(tag)} x="{x}" y="{y}"></text>'
            if tag
            else ""
        )

    # --- wires

    def _wire(self, path: str) -> None:
        self._svg.append(f'<path class="wire" d="{path}"/>')

    def _wires(self, number: int, transition: Transition) -> None:
        """Draw the wires of a transition; a double line joins simultaneous branches."""
        column, row = self._cells.transitions[number]
        x, y = self._middle(column), self._tops[row] + 11
        above, below = self._tops[row] - GAP // 2, self._tops[row] + LINE + 4 + GAP // 2
        sources = [self._cells.steps[name.upper()] for name in transition.sources]
        targets = [
            self._cells.steps[name.upper()]
            for name in transition.targets
            if (number, name.upper()) not in self._cells.jumps
        ]
        starts = [
            (self._middle(step_column), self._tops[level] + STEP_HIGH) for step_column, level in sources
        ]
        ends = [(self._middle(step_column), self._tops[level]) for step_column, level in targets]
        self._joined(starts, (x, y), above)
        if len(ends) == 1:  # down in a separate column, then across just above the step
            self._joined(ends, (x, y), ends[0][1] - GAP // 2)
        elif ends:
            self._joined(ends, (x, y), below)

    def _joined(self, ends: list[tuple[int, int]], point: tuple[int, int], bar: int) -> None:
        """Draw wires between a transition at `point` and its steps at `ends`, which meet at height `bar`."""
        x, y = point
        if len(ends) == 1:
            self._wire(f"M{x} {y}V{bar}H{ends[0][0]}V{ends[0][1]}")
            return
        self._wire("".join(f"M{end_x} {end_y}V{bar}" for end_x, end_y in [*ends, point]))
        self._double([x, *(end_x for end_x, _ in ends)], bar)

    def _double(self, middles: list[int], y: int) -> None:
        left, right = min(middles) - 12, max(middles) + 12
        self._svg.append(f'<path class="wire double" d="M{left} {y - 2}H{right}M{left} {y + 2}H{right}"/>')


def _text(x: int, y: int, text: str, kind: str) -> str:
    return f'<text class="{kind}" x="{x}" y="{y}">{plain(text)}</text>'


def chart_lines(chart: Chart) -> Iterator[tuple[int, str]]:
    """Yield a chart as numbered lines: each step, its actions, and its outgoing transitions."""
    for step in chart.steps:
        yield step.number, step.head
        for action in step.actions:
            yield action.number, f"    {action.head}"
            yield from ((0, f"        {line}") for line in action_lines(action)[1:])
        for leaving in chart.transitions_after(step.name):
            joined = (
                f" with {', '.join(name for name in leaving.sources if name.upper() != step.name.upper())}"
            )
            yield (
                leaving.number,
                f"  + {leaving.name}{joined if len(leaving.sources) > 1 else ''}: {leaving.condition}",
            )
            yield 0, f"    -> {', '.join(leaving.targets)}"
