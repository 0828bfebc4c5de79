#!/usr/bin/env bash
# what: small-mcap sorts the messages of a chunk by time only when it reads in reverse
# date: 2026-11-29
# meets: anyone who merges recordings or logs several sources into one file
# expected: by log time, as mcap does
# behavior:
#   The messages of one chunk have the times 10, 30, 20, 40. mcap sorts them by log time. small-mcap gives them as they
#   lie in the chunk, also for a file with an index; with reverse=True it sorts them, so the one is not the other's reverse.
# product: Recordings are written in order of time, so both readers agree; see [traces](traces.md)
# output:
#   mcap, reverse False [10, 20, 30, 40]
#   small-mcap, reverse False [10, 30, 20, 40]
#   mcap, reverse True [40, 30, 20, 10]
#   small-mcap, reverse True [40, 30, 20, 10]
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install mcap==1.6.0 small-mcap==0.16.0
observe python - <<'PY'
from mcap.reader import make_reader
from mcap.writer import Writer
from small_mcap import read_message

with open("four.mcap", "wb") as file:
    writer = Writer(file)
    writer.start()
    schema = writer.register_schema("level", "jsonschema", b'{"type": "object"}')
    channel = writer.register_channel("/level", "json", schema)
    for when in (10, 30, 20, 40):
        writer.add_message(channel, when, b"{}", when)
    writer.finish()
for reverse in (False, True):
    with open("four.mcap", "rb") as file:
        print("mcap, reverse", reverse, [each.log_time for *_, each in make_reader(file).iter_messages(reverse=reverse)])
    with open("four.mcap", "rb") as file:
        print("small-mcap, reverse", reverse, [each.log_time for *_, each in read_message(file, reverse=reverse)])
PY
