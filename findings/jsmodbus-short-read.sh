#!/usr/bin/env bash
# what: jsmodbus answers a read beyond the end of its registers with fewer values and no exception
# date: 2026-11-30
# meets: pollers that are tested against a simulated device, and rely on exception 02 for a wrong address
# expected: exception 02, as the same server answers a write there
# behavior:
#   The server cuts the request down to its buffer. Four registers from 8 on a table of ten come back as two, and its
#   client resolves. A read of 126 registers, which is illegal (1 to 125), returns ten.
# product: A read beyond the mapped tags is exception 02, a count above 125 exception 03: [Modbus](hmi.md#modbus)
# output:
#   read 4 from 6: 4 values
#   read 4 from 8: 2 values
#   read 126 from 0: 10 values
#   write 3 from 9: ModbusException
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install jsmodbus@5.0.0
cat >poll.js <<'JS'
const net = require("net");
const modbus = require("jsmodbus");

const listener = new net.Server();
new modbus.server.TCP(listener, { holding: Buffer.alloc(20) });
listener.listen(0, "127.0.0.1", () => {
    const socket = net.connect(listener.address().port, "127.0.0.1");
    const client = new modbus.client.TCP(socket, 1, 5000);
    const attempt = async (name, request) => {
        try {
            const { response } = await request;
            console.log(`${name}: ${response.body.valuesAsArray.length} values`);
        } catch (error) {
            console.log(`${name}: ${error.err}`);
        }
    };
    socket.on("connect", async () => {
        await attempt("read 4 from 6", client.readHoldingRegisters(6, 4));
        await attempt("read 4 from 8", client.readHoldingRegisters(8, 4));
        await attempt("read 126 from 0", client.readHoldingRegisters(0, 126));
        await attempt("write 3 from 9", client.writeMultipleRegisters(9, [1, 2, 3]));
        process.exit(0);
    });
});
JS
observe node poll.js
