"""The script of the operator panel without a browser: which orders a page gives, and what it says it holds.

Broken on purpose: `confirm` only after the last release, an order for each button at a hello, an answer that
comes after the hello forgotten: a test turns red.
"""

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

WEB = Path(__file__).parents[3] / "scanrack" / "watch" / "web"

STAGE = """
globalThis.addEventListener = () => {};
globalThis.document = { addEventListener() {}, documentElement: {} };
globalThis.window = globalThis;
export const said = [], builders = { hello: [], program: [] }, items = {}, waiting = [];
export const run = { state: "live", scan: 5, machine: {}, hello: {} };
"""
"""What the stand-ins for the other scripts share."""

STUBS = {
    "dom.js": """
        const node = () => ({ append() {}, replaceChildren() {}, addEventListener() {}, setAttribute() {},
          dataset: {}, style: { setProperty() {} }, matches: () => true });
        export const at = node, button = node, el = node, heading = node;
        export const setAttribute = () => {}, setFlag = () => {}, setText = () => {};""",
    "link.js": "export const link = () => {}, requested = () => ({});",
    "notice.js": "export const tell = text => { throw new Error(text); };",
    "orders.js": """
        import { said, waiting } from "./stage.js";
        export const recorded = () => false;
        export const operate = order => {
          said.push(`${order.name} ${order.on}`);
          return new Promise(resolve => waiting.push(resolve));
        };""",
    "panelitems.js": """
        import { items } from "./stage.js";
        export const lay = () => {};
        export const itemOf = (item, bound, does) => {
          items[item.name] = does;
          return { node: { matches: () => true, setAttribute() {} }, show() {} };
        };""",
    "paneledit.js": "export const editing = () => null, editor = () => {};",
    "source.js": """
        import { said } from "./stage.js";
        export const ask = async (what, { give } = {}) => {
          if (what === "hold") said.push(`holds ${give.map(each => each.name).join(" ") || "none"}`);
          return new Promise(() => {});
        };""",
    "state.js": """
        import { builders } from "./stage.js";
        export { run } from "./stage.js";
        export const onHello = build => builders.hello.push(build), onPaint = () => {};
        export const onProgram = build => { builders.hello.push(build); builders.program.push(build); };""",
    "values.js": "export const bindValue = () => {}, unbindIn = () => {};",
    "watchtable.js": "export const alsoWatched = [], sendWatched = () => {};",
}

BEGIN = """
import { builders, items, run, said, waiting } from "./stage.js";
import { take } from "./panel.js";
const item = name => ({ name, kind: "momentary", at: [0, 0], size: [1, 1] });
const bound = name => ({ read: `1.input.${name}`, press: [1, name, false], type: "BOOL", broken: "" });
take({ file: "x.panel", items: [item("A"), item("B")], bound: [bound("A"), bound("B")] });
const settled = () => new Promise(resolve => setTimeout(resolve));
const answer = async what => { waiting.shift()(what); await settled(); };
const hello = () => { for (const build of builders.hello) build(run.hello); };
said.length = 0;
"""

PRESSED = "items.A.press(); await answer({ scan: 5 });"


@pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
@pytest.mark.parametrize(
    ("script", "expected"),
    [
        (f"{PRESSED} items.A.release();", ["holds A", "A true", "A false", "holds none"]),
        # what is still pressed is confirmed without the one that was let go
        (
            f"{PRESSED} items.B.press(); await answer({{ scan: 5 }}); items.A.release();",
            ["holds A", "A true", "holds A B", "B true", "A false", "holds B"],
        ),
        ("items.A.press(); await answer(null);", ["holds A", "A true", "holds none"]),  # refused
        # the server has let go: the page gives no order
        (f"{PRESSED} hello(); items.A.release();", ["holds A", "A true", "holds none"]),
        ("hello();", []),
        # ... but not for a press that came to it after that
        (
            "items.A.press(); hello(); await answer({ scan: 5 });",
            ["holds A", "A true", "holds none", "A false"],
        ),
        ("items.A.press(); hello(); await answer(null);", ["holds A", "A true", "holds none"]),
        # another program with the connection as it was: the button stays pressed
        (f"{PRESSED} for (const build of builders.program) build();", ["holds A", "A true"]),
    ],
)
def test_each_press_is_let_go_once_and_the_server_knows_what_is_held(tmp_path, script, expected):
    for name, text in {**STUBS, "stage.js": STAGE}.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    shutil.copy(WEB / "panel.js", tmp_path)
    imported = set(re.findall(r'from "\./(.+?)"', (WEB / "panel.js").read_text("utf-8")))
    assert imported == set(STUBS)
    (tmp_path / "package.json").write_text('{"type": "module"}', encoding="utf-8")
    end = "\nawait settled();\nconsole.log(JSON.stringify(said));\nprocess.exit(0);\n"
    (tmp_path / "play.js").write_text(BEGIN + script + end, encoding="utf-8")
    done = subprocess.run(
        ["node", "play.js"], cwd=tmp_path, capture_output=True, text=True, check=False, encoding="utf-8"
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == expected
