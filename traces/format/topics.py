"""The topics other than /scan. Their JSON messages are written only when something changes.

Every message has the number of the scan that reported it.

    /events     a module's event, or an edit        a rule fired, a move began or ended, or the program
                                                    was edited between two scans
    /stimuli    the machine or a person acted       a button of the timeline, a station's pulse
    /indicators the lights of a module changed      as on the front panel
    /forces     the forced bits and tags            all of them in each message
    /cpu        mode and health of the controller   all of it in each message
    /faults     the controller faulted              scan and cause
    /texts      a recorded text changed             only if texts are recorded
    /orders     the rack was operated               only in a session of scanrack watch
    /sequences  a new wait of a sequence            only if the program has sequences
"""

from __future__ import annotations

import json

from scanrack.io_images.dataclass import dataclass

SCAN_TOPIC = "/scan"
MESSAGE_ENCODING = "json"
SCHEMA_ENCODING = "jsonschema"

Properties = dict[str, dict[str, str]]

_SCAN: Properties = {
    "scan": {"type": "integer", "description": "number of the scan in which it became known"}
}
_SLOT: Properties = {"slot": {"type": "integer", "description": "number of the slot it belongs to"}}


@dataclass(frozen=True, slots=True)
class Topic:
    """A topic of JSON messages."""

    name: str
    schema: str
    description: str  # for the schema
    properties: Properties  # JSON schema of its known fields; messages may have others
    state: bool = False  # whether a message has the whole state; an unchanged state is not written again

    @property
    def schema_text(self) -> str:
        """The JSON schema of the topic's messages."""
        schema = {
            "title": self.schema,
            "description": self.description,
            "type": "object",
            "properties": {**_SCAN, **self.properties},
            "required": ["scan"],
        }
        return json.dumps(schema, separators=(",", ":"))


TOPICS = (
    Topic(
        "/events",
        "scanrack.Event",
        "Something happened in a module.",
        {
            **_SLOT,
            "kind": {"type": "string", "description": "rule or move"},
            "name": {"type": "string", "description": "id of the rule, kind of the move"},
            "text": {"type": "string", "description": "a sentence for people"},
        },
    ),
    Topic(
        "/stimuli",
        "scanrack.Stimulus",
        "The machine or a person acted on a module.",
        {
            **_SLOT,
            "kind": {"type": "string", "description": "stimulus"},
            "name": {"type": "string", "description": "name of the input"},
            "text": {"type": "string", "description": "a sentence for people"},
        },
    ),
    Topic(
        "/indicators",
        "scanrack.Indicators",
        "The lights on a module's front changed.",
        {
            **_SLOT,
            "module": {"type": "string", "description": "off or solid"},
            "axis_ok": {"type": "string", "description": "off, solid, blinking or alternating"},
            "axis_error": {"type": "string", "description": "off, solid, blinking or alternating"},
        },
    ),
    Topic(
        "/forces",
        "scanrack.Forces",
        "The forces in effect, all of them.",
        {},
        state=True,
    ),
    Topic(
        "/cpu",
        "scanrack.Cpu",
        "Mode and health of the CPU.",
        {"mode": {"type": "string", "description": "program, run, test or single scan"}},
        state=True,
    ),
    Topic(
        "/faults",
        "scanrack.Fault",
        "The CPU faulted.",
        {"text": {"type": "string", "description": "what went wrong, and where"}},
    ),
)
"""Every topic other than /scan, in the order of their channels."""

TEXTS = Topic(
    "/texts",
    "scanrack.Text",
    "A recorded text changed.",
    {
        "tag": {"type": "string", "description": "full name of the tag"},
        "code": {"type": "integer", "description": "what stands for the text in /scan"},
        "text": {"type": "string", "description": "the text"},
    },
)
"""The topic of a trace whose tags have texts; codes in /scan refer to them."""

ORDERS = Topic(
    "/orders",
    "scanrack.Order",
    "The running rack was operated, before this scan.",
    {
        "kind": {"type": "string", "description": "order"},
        "name": {"type": "string", "description": "what was ordered, such as press"},
        "text": {"type": "string", "description": "a sentence for people"},
        "order": {"type": "string", "description": "the order itself, JSON"},
    },
)
"""The topic of operator actions in a session's trace, which are needed to repeat the session."""

SEQUENCES = Topic(
    "/sequences",
    "scanrack.Sequence",
    "A sequence of the program waits somewhere else, or is over.",
    {
        "sequence": {"type": "string", "description": "name of the sequence"},
        "file": {"type": "string", "description": "name of the file that it waits in; empty once it is over"},
        "line": {"type": "integer", "description": "the line that it waits at; 0 once it is over"},
        "wait": {"type": "string", "description": "what it waits for; empty once it is over"},
    },
)
"""The topic of a trace whose program has sequences."""

ALL_TOPICS = (*TOPICS, TEXTS, ORDERS, SEQUENCES)
"""Every topic that a trace can have in addition to /scan, in the order of the channels."""
