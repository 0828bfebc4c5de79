// Where the page's data come from: the server. A shared page has embedded.js in the place of socket.js.

export { ask, connect, Refused } from "./socket.js";
