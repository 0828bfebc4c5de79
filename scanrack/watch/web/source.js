// The source of the page's data: the server. In a shared page embedded.js takes the place of socket.js.

export { ask, connect, Refused } from "./socket.js";
