// Where the page's data come from: out of the page itself if it was shared, else from the server.

export const { connect, ask, Refused } = document.getElementById("data") ? await import("./embedded.js") : await import("./socket.js");
