#!/usr/bin/env bash
# what: three ROS 2 readers return a field named `in` in three different ways, and one of them reads no message that has it
# date: 2026-11-29
# meets: anyone who reads a recording whose message has a field that is a keyword of Python
# expected: all read it, as an attribute that takes getattr
# behavior:
#   A field of a ROS 2 message may have the name in. mcap-ros2-support gives an attribute that only getattr reaches;
#   rosbags calls it in_; pybag-sdk makes a dataclass of the message and raises TypeError for the whole topic.
# product: The images are `outputs` and `inputs`, and no field of a recording is a keyword; see [traces](traces.md#reading-one-in-python)
# output:
#   mcap-ros2-support: in 5 in_ None
#   rosbags: in None in_ 5
#   pybag-sdk: TypeError: Field names must not be keywords: 'in'
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install mcap==1.6.0 mcap-ros2-support==0.6.0 rosbags==0.11.9 pybag-sdk==0.13.0
observe python - <<'PY'
from pathlib import Path

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from mcap_ros2.writer import Writer
from pybag.mcap_reader import McapFileReader
from rosbags.highlevel import AnyReader

with open("slot.mcap", "wb") as file:
    writer = Writer(file)
    schema = writer.register_msgdef("cell_msgs/msg/Slot", "int16 in\nint16 out\n")
    writer.write_message("/slot", schema, {"in": 5, "out": 7}, log_time=1, publish_time=1)
    writer.finish()
with open("slot.mcap", "rb") as file:
    for *_, message in make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
        print("mcap-ros2-support: in", getattr(message, "in", None), "in_", getattr(message, "in_", None))
with AnyReader([Path("slot.mcap")]) as reader:
    for connection, _, raw in reader.messages():
        message = reader.deserialize(raw, connection.msgtype)
        print("rosbags: in", getattr(message, "in", None), "in_", getattr(message, "in_", None))
with McapFileReader.from_file("slot.mcap") as reader:
    try:
        print("pybag-sdk:", list(reader.messages("/slot")))
    except TypeError as error:
        print("pybag-sdk: TypeError:", error)
PY
