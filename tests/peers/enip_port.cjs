// Sends what goes to port 44818, the only one that some packages know, to the port in ENIP_PORT.
const net = require('net');
const port = +process.env.ENIP_PORT;
const connect = net.Socket.prototype.connect;
net.Socket.prototype.connect = function (...words) {
  const first = Array.isArray(words[0]) ? words[0][0] : words[0];
  if (first === 44818) words[0] = port;
  else if (first && first.port === 44818) first.port = port;
  return connect.apply(this, words);
};
