"""Describes events in sentences: a rule that fired, a button, a force, a mode, a fault and others."""

from __future__ import annotations

from collections.abc import Callable, Mapping

OF_ADAPTERS = ("refusal", "adapter")
"""Kinds of events in which an adapter sets bits because of its attached device."""


def move_wording(kind: object, outcome: object) -> str:
    """Return a kind of move and its outcome as text.

    >>> move_wording("absolute", "complete"), move_wording("home", "home")
    ('absolute: complete', 'search for home: found')
    """
    if kind == "home":
        return f"search for home: {'found' if outcome == 'home' else outcome}"
    return f"{kind}: {outcome}"


def describe(topic: str, scan: int, fields: Mapping[str, object]) -> str:
    """Return a message of a topic other than /scan as text.

    >>> fields = {"slot": 1, "kind": "rule", "name": "CMD-03", "bits": ["COMMAND_ERROR"],
    ...     "section": "chapter 6, Command Error 3", "text": "A move was started before the last one ended."}
    >>> describe("/events", 4711, fields)
    'COMMAND_ERROR at scan 4711: a move was started before the last one ended [CMD-03, chapter 6]'
    >>> describe("/cpu", 0, {"mode": "run"}), describe("/forces", 9, {"slot1.I.2": 5})
    ('the CPU is in run mode', 'forces: slot1.I.2 = 5')
    >>> describe("/forces", 9, {"slot1.I.2": 5, "tags": {"Run": True}})
    'forces: slot1.I.2 = 5, Run = True'
    """
    return _BY_TOPIC.get(topic, _event)(scan, fields)


def _event(scan: int, fields: Mapping[str, object]) -> str:
    if fields.get("kind") == "rule" or (fields.get("kind") in OF_ADAPTERS and fields.get("bits")):
        return _rule(scan, fields)
    return str(fields.get("text") or _pairs(fields))


def _rule(scan: int, fields: Mapping[str, object]) -> str:
    """Return a rule as text: the bits that it set, its scan and clause, its name and chapter."""
    bits = fields.get("bits")
    names = " ".join(map(str, bits)) if isinstance(bits, list) and bits else "rule"
    chapter = str(fields.get("section", "")).partition(",")[0]
    source = ", ".join(source_part for source_part in (str(fields.get("name", "")), chapter) if source_part)
    return f"{names} at scan {scan}: {_clause(str(fields.get('text', '')))} [{source}]"


def _clause(sentence: str) -> str:
    """Return a sentence as a clause, in lower case unless it begins with a name in capitals."""
    sentence = sentence.removesuffix(".")
    if sentence[1:2].isupper() or sentence[1:2] in "-_":
        return sentence
    return sentence[:1].lower() + sentence[1:]


def _cpu(_: int, fields: Mapping[str, object]) -> str:
    return f"the CPU is in {fields['mode']} mode" if "mode" in fields else f"CPU: {_pairs(fields)}"


def _forces(_: int, fields: Mapping[str, object]) -> str:
    tags = fields.get("tags")
    bits = {name: value for name, value in fields.items() if name != "tags"}
    return f"forces: {_pairs(bits | tags if isinstance(tags, dict) else bits)}"


def _fault(_: int, fields: Mapping[str, object]) -> str:
    location = f" [{fields['where']}]" if fields.get("where") else ""
    cause = f", by the {fields['cause']}" if fields.get("cause") else ""
    return f"the CPU faulted{cause}: {fields.get('text', '')}{location}"


def _sequence(_: int, fields: Mapping[str, object]) -> str:
    """Describe the line and condition at which a sequence waits, or say that the sequence is over."""
    name, line = fields.get("sequence"), fields.get("line")
    if not line:
        return f"{name} is over"
    return f"{name} waits at line {line} of {fields.get('file')} for {fields.get('wait')}"


def _pairs(fields: Mapping[str, object]) -> str:
    return ", ".join(f"{name} = {value}" for name, value in fields.items()) or "none"


_BY_TOPIC: Mapping[str, Callable[[int, Mapping[str, object]], str]] = {
    "/cpu": _cpu,
    "/forces": _forces,
    "/faults": _fault,
    "/sequences": _sequence,
}
