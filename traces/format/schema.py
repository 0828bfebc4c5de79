"""The schema of a scan, with which any MCAP viewer shows the raw words as named fields.

`ros2msg` text with the nested definitions after separators, one message type
per module and direction:

    uint32 scan
    uint32 flags
    Amci3601 slot1
    ====...
    MSG: scanrack/Amci3601
    Amci3601Out outputs Amci3601In inputs ====...
    MSG: scanrack/Amci3601Out
    int16 command_msw
    ...

The payload is CDR, little-endian. Two uint32 followed by int16 need no padding, so the rack's memory block is
copied unchanged. The padding at the end of the block is the field `int16[N] padding`:

    byte  0            4     8      12
          00 01 00 00  scan  flags  slot outputs, slot inputs, ...

If a user selects tags, they follow the slots; see `tagplan`. A reader ignores fields after the tags,
such as decoded values in an exported copy; see `decoded`.

Viewers merge schemas with the same name, so the name ends with a hash of the text. No underscore precedes
the hash, since ROS 2 allows only letters and digits in the name of a message, and its decoders enforce that.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from struct import Struct

from scanrack.io_images.dataclass import dataclass

from .cdr import leaves
from .layout import SlotInfo, block_layout
from .named_words import SEPARATOR, split_schema
from .tagplan import FIELD, TagPlan

FORMAT = 1
"""Version of the format. Readers refuse later versions."""

FORMAT_WITH_TAGS = 2
"""Version of a trace with fields after the slots. A trace without these fields has version `FORMAT`."""

LIBRARY = "scanrack "
"""Prefix of scanrack's name in a file's header; the version follows it."""

METADATA = "scanrack"
"""Name of the metadata record."""

SCHEMA_ENCODING = "ros2msg"
MESSAGE_ENCODING = "cdr"
PROFILE = "ros2"
NAME_STEM = "scanrack/msg/Scan"

CDR_PREFIX = 0x0000_0100
"""The bytes 00 01 00 00 read as a little-endian word: CDR, little-endian, no options."""

SCAN_HEAD = Struct("<III")
"""CDR prefix, scan number modulo 2**32, flags; the memory block follows."""

PADDING = "padding"
"""Name of the field for words at the end of the memory block that do not belong to a module."""

IMAGE_FIELDS = ("outputs", "inputs")
"""Fields for a slot's images. No field is a Python keyword, since readers turn fields into attributes."""

LEAVES_MAX, REST_BYTES_MAX = 100_000, 1 << 20
"""Maximum number of values in a scan with fields after the tags, and maximum bytes of these fields."""

_HASH_DIGITS = 12


@dataclass(frozen=True, slots=True)
class ScanSchema:
    """The schema of the scans of one rack."""

    layout: str  # hash of the text, twelve hexadecimal digits
    text: str  # the ros2msg definition

    @property
    def name(self) -> str:
        """The schema's name. Each layout has its own name."""
        return NAME_STEM + self.layout


ExtraField = tuple[str, Sequence[tuple[str, Sequence[str]]]]
"""A field after the tags: its name, and its messages with their lines. The first message is its type."""


def scan_schema(
    slots: Sequence[SlotInfo],
    tags: TagPlan | None = None,
    extra: ExtraField | None = None,
) -> ScanSchema:
    """Return the schema of a scan of these slots and tags, and of an extra field if it is not None.

    >>> schema = scan_schema([SlotInfo(1, "amci3601", "4.1")])
    >>> schema.text.splitlines()[:3], schema.name == "scanrack/msg/Scan" + schema.layout
    (['uint32 scan', 'uint32 flags', 'Amci3601 slot1'], True)
    """
    lines = ["uint32 scan", "uint32 flags"]
    lines += [f"{slot.words.message} slot{slot.number}" for slot in slots]
    messages: list[tuple[str, Sequence[str]]] = []
    outputs, inputs = IMAGE_FIELDS
    for words in dict.fromkeys(slot.words for slot in slots):
        stem = words.message
        messages.append((stem, [f"{stem}Out {outputs}", f"{stem}In {inputs}"]))
        messages.append((f"{stem}Out", [f"int16 {name}" for name in words.outputs]))
        messages.append((f"{stem}In", [f"int16 {name}" for name in words.inputs]))
    padding = block_layout(slots).padding
    if padding:
        lines.append(f"int16[{padding}] {PADDING}")
    if tags is not None:
        lines.append(f"{tags.message} {FIELD}")
        messages += tags.messages()
    if extra is not None:
        field, extra_messages = extra
        message_name, _ = extra_messages[0]
        lines.append(f"{message_name} {field}")
        messages += extra_messages
    for name, fields in messages:
        lines += [SEPARATOR, f"MSG: scanrack/{name}", *fields]
    text = "\n".join(lines) + "\n"
    return ScanSchema(layout_of(text), text)


def layout_of(text: str) -> str:
    """Return the hash of a schema's text, which ends its name."""
    return hashlib.sha256(text.encode()).hexdigest()[:_HASH_DIGITS]


def rest_bytes(text: str, known: ScanSchema) -> int | None:
    """Return the size of a scan's unknown fields, bytes; None if the known fields are not first.

    Args:
        text: the schema with unknown fields.
        known: the schema of the same slots and tags, without unknown fields.

    Raises:
        ValueError: an unknown field has no fixed size.
    """
    if text == known.text:
        return 0
    (fields, messages), (known_fields, known_messages) = split_schema(text), split_schema(known.text)
    if fields[: len(known_fields)] != known_fields:
        return None
    if any(messages.get(name) != lines for name, lines in known_messages.items()):
        return None
    *_, last_known = leaves(known_fields, messages, 0)
    end = 0
    for count, leaf in enumerate(leaves(fields, messages, 0)):
        end = leaf.end
        if count >= LEAVES_MAX or end - last_known.end > REST_BYTES_MAX:
            raise ValueError(f"they have more than {LEAVES_MAX:,} values or {REST_BYTES_MAX:,} bytes")
    return end - last_known.end
