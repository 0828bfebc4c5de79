"""The style sheet of a comparison page, light and dark, for phones and wider screens."""

STYLE = """
:root { color-scheme: light dark; --ink: #1b1f24; --soft: #57606a; --paper: #ffffff; --field: #f6f8fa;
  --line: #d0d7de; --gone: #cf222e; --gone-field: #ffe5e8; --come: #1a7f37; --come-field: #d9f5df;
  --moved: #8250df; --changed: #9a6700 }
@media (prefers-color-scheme: dark) { :root { --ink: #e6edf3; --soft: #9198a1; --paper: #0d1117;
  --field: #151b23; --line: #30363d; --gone: #ff7b72; --gone-field: #4a1c20; --come: #56d364;
  --come-field: #12391f; --moved: #bc8cff; --changed: #d29922 } }
* { box-sizing: border-box }
body { margin: 0; background: var(--paper); color: var(--ink); font: 15px/1.45 system-ui, sans-serif }
header, nav, main { max-width: 1500px; margin: 0 auto; padding: 0 clamp(10px, 2vw, 28px) }
h1 { font-size: 1.45em; margin: .9em 0 .2em } h1 span { unicode-bidi: isolate; overflow-wrap: anywhere }
.summary { margin: .2em 0; color: var(--soft) }
details { color: var(--soft) } details ul { margin: .3em 0 }
nav ol { columns: 22em; padding: .7em 0 .7em 1.6em; margin: .8em 0; border-block: 1px solid var(--line) }
nav li { break-inside: avoid; overflow-wrap: anywhere } nav b { margin-left: .5em; font-size: .9em }
a { color: inherit }
section { margin-top: 1.6em }
h2 { font-size: 1.15em; margin: 0; padding: .45em 0; border-bottom: 2px solid var(--line);
  position: sticky; top: 0; background: var(--paper); overflow-wrap: anywhere }
article { border-left: 3px solid var(--line); margin: 1em 0; padding-left: .8em }
article.added { border-color: var(--come) } article.removed { border-color: var(--gone) }
article.moved, article.renamed { border-color: var(--moved) } article.changed { border-color: var(--changed) }
b.added { color: var(--come) } b.removed { color: var(--gone) } b.moved, b.renamed { color: var(--moved) }
b.changed { color: var(--changed) }
h3 { font-size: 1em; margin: 0 0 .35em; overflow-wrap: anywhere }
.sides { display: grid; grid-template-columns: minmax(0, 1fr) minmax(0, 1fr); gap: 0 14px;
  margin-bottom: .3em }
.old, .new, .alone { overflow-x: auto; padding: .35em .6em; background: var(--field); border-radius: 5px }
.old:empty, .new:empty { background: none; padding: 0 }
.fields .sides { margin-bottom: 2px }
pre { margin: .15em 0; white-space: pre-wrap; overflow-wrap: anywhere; unicode-bidi: isolate }
pre, .rung text { font-family: "DejaVu Sans Mono", Menlo, Consolas, monospace; font-size: 13px }
.rung + pre { color: var(--soft); font-size: 12px }
.comment { margin: .1em 0; color: var(--soft); white-space: pre-line; overflow-wrap: anywhere }
del { background: var(--gone-field); color: var(--gone) }
ins { background: var(--come-field); color: var(--come); text-decoration-thickness: 2px }
.rung { display: block; margin: .3em 0; max-width: 100%; min-width: 300px; height: auto }
.rung text { fill: var(--ink); white-space: pre }
.rung .caption { fill: var(--soft) } .rung .heading { font-weight: bold }
.wire, .sign { stroke: var(--soft); stroke-width: 1.4; fill: none }
.rail { stroke: var(--ink); stroke-width: 2.5 }
.box { stroke: var(--soft); stroke-width: 1.4; fill: var(--paper) }
.field { stroke-width: 1.5; stroke-dasharray: 4 2 }
.old .field { fill: var(--gone-field); stroke: var(--gone) }
.new .field { fill: var(--come-field); stroke: var(--come) }
.new .field, .old .field { stroke-opacity: .8 } .new .field { stroke-dasharray: none }
@media (max-width: 820px) {
  .sides { grid-template-columns: minmax(0, 1fr); gap: 3px }
  .old:not(:empty)::before { content: "before"; color: var(--gone); font-size: 12px }
  .new:not(:empty)::before { content: "after"; color: var(--come); font-size: 12px }
  .fields .old::before, .fields .new::before { content: none }
  .fields .old:not(:empty) { border-left: 3px solid var(--gone) }
  .fields .new:not(:empty) { border-left: 3px solid var(--come) }
  nav ol { columns: 1 }
}
@media print { h2 { position: static } .old, .new, .alone { overflow: visible } }
"""
