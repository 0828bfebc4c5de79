#!/usr/bin/env bash
# what: cm-ethernetip's tag server counts later fragments of an array from element 0, whatever element the client began at
# date: 2026-11-30
# meets: anyone who reads the upper part of a long array from a simulated Logix controller
# expected: element 100 + i at place i of `counts[100]`, 400 elements
# behavior:
#   The first 478 bytes are right. For the rest the client asks for the same tag at a byte offset; the server leaves out
#   the index in the path. The status is Success, 239 values are right and 161 are those of other elements.
# product: Its EtherNet/IP server adds the offset to the element of the path: [HMI](hmi.md#what-clients-see)
# output:
#   counts[0], 600 elements: Success, 600 right
#   counts[100], 200 elements: Success, 200 right
#   counts[100], 400 elements: Success, 239 right, the next is 239 in place of 339
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install cm-ethernetip==0.1.0 pylogix==1.1.6
observe python - <<'PY'
import asyncio
import struct

from ethernetip.cip.identity_info import IdentityInfo
from ethernetip.logix import data_types
from ethernetip.logix.logix_dispatcher import LogixDispatcher
from ethernetip.logix.tag_database import TagDatabase
from ethernetip.protocol.eip_adapter import EipAdapter
from pylogix import PLC

PORT = 18105


def read():
    with PLC("127.0.0.1", port=PORT, timeout=10) as plc:
        for first, count in ((0, 600), (100, 200), (100, 400)):
            answer = plc.Read(f"counts[{first}]", count)
            wrong = [place for place, value in enumerate(answer.Value) if value != first + place]
            line = f"counts[{first}], {count} elements: {answer.Status}, {count - len(wrong)} right"
            if wrong:
                line += f", the next is {answer.Value[wrong[0]]} in place of {first + wrong[0]}"
            print(line)


async def main():
    tags, identity = TagDatabase(), IdentityInfo(product_name="Sample")
    tags.add_tag("counts", data_types.INT, element_count=600).set_data(struct.pack("<600h", *range(600)), 0)
    await EipAdapter(LogixDispatcher(tags, identity), identity).listen("127.0.0.1", PORT)
    await asyncio.to_thread(read)


asyncio.run(main())
PY
