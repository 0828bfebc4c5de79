// What browsers have beside the library of TypeScript, and elements as the page's selectors find them.

interface Element {
  readonly dataset: DOMStringMap;
}

interface EventTarget {
  closest(selectors: string): Element | null;
}

interface JSON {
  rawJSON?(text: string): unknown; // ECMAScript 2026
}

interface WebSocket {
  drop?(): void; // see socket.js
}
