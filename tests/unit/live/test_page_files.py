"""What a browser gets of the page: one script of all modules, the style within the page, packed, once.

Broken on purpose: a module left out of the order, a property renamed, a shorthand not written out, a name of
another module not renamed, the embedded source joined instead of the socket, the gzip of a browser that wants
none, a tag that does not depend on the content: each turns a test red.
"""

import gzip
import re
from base64 import b64encode
from hashlib import sha256
from importlib.resources import files

import pytest
from scanrack.watch.gate import Gate
from scanrack.watch.joining import joined

HOST = "127.0.0.1"
GATE = Gate(HOST, 80, "00")  # which makes each file once
WEB = files("scanrack.watch") / "web"


def answer(path="/", **more):
    found = GATE.respond(path, HOST, None, **more)
    assert found is not None
    return found


# --- joining


def script(**modules):
    return joined({f"{name}.js": text for name, text in modules.items()}).script


def test_modules_come_in_the_order_of_their_imports_each_once():
    text = script(
        main='import "./b.js";\nimport "./a.js";\nrun("main");\n',
        a='import "./b.js";\nrun("a");\n',
        b='run("b");\n',
    )
    assert re.findall(r'run\("(\w+)"\)', text) == ["b", "a", "main"]


def test_names_of_two_modules_stay_apart_and_those_imported_are_the_other_modules():
    text = script(
        main='import { key as other } from "./a.js";\nconst key = 1;\nsay(key, other);\n',
        a="export const key = 2;\n",
    )
    assert text == "const key$0 = 2;\nconst key$1 = 1;\nsay(key$1, key$0);\nexport { key$0 };\n"


@pytest.mark.parametrize(
    ("code", "wanted"),
    [
        ("run.at;", "run.at;"),
        ("run?.at;", "run?.at;"),
        ("call(...at);", "call(...at$0);"),
        ("const x = { at };", "const x$0 = { at: at$0 };"),
        ("const x = { a: 1, at, b: at };", "const x$0 = { a: 1, at: at$0, b: at$0 };"),
        ("const x = { at: 1 };", "const x$0 = { at: 1 };"),
        ("const x = y ? at : z;", "const x$0 = y ? at$0 : z;"),
        ("const f = ({ at = 5 }) => at;", "const f$0 = ({ at: at$0 = 5 }) => at$0;"),
        ("const { a: x } = at;", "const { a: x$0 } = at$0;"),
        ("const [x, y] = at;", "const [x$0, y$0] = at$0;"),
        ("const [[x], y] = at;", "const [[x$0], y$0] = at$0;"),
        ("const { a: { b: x }, c: y } = at;", "const { a: { b: x$0 }, c: y$0 } = at$0;"),
        ("const x = { at(y) { return at; } };", "const x$0 = { at(y) { return at$0; } };"),
        (
            "class A { at() { return at; } get b() { at(); } }",
            "class A$0 { at() { return at$0; } get b() { at$0(); } }",
        ),
        ("if (x) { at(); } else { at(); }", "if (x) { at$0(); } else { at$0(); }"),
        ("try { at(); } catch { at(); }", "try { at$0(); } catch { at$0(); }"),
        ("const x = () => { at(); };", "const x$0 = () => { at$0(); };"),
        ('say("at", `at ${at} at ${{ at }.at}`);', 'say("at", `at ${at$0} at ${{ at: at$0 }.at}`);'),
        ("say(/at {/g, at / 2 / at);", "say(/at {/g, at$0 / 2 / at$0);"),
        ("say(at); // at", "say(at$0);"),
        ("let x = f(1, 2), y = at;", "let x$0 = f(1, 2), y$0 = at$0;"),
    ],
)
def test_a_name_is_renamed_where_it_is_one_and_a_property_stays(code, wanted):
    text = script(main=f"function at() {{}}\n{code}\n")
    assert [each.rstrip() for each in text.splitlines()][1] == wanted


def test_a_module_as_a_whole_gives_its_members():
    text = script(
        main='import * as a from "./a.js";\nsay(a.one(), a.two);\n',
        a="export function one() {}\nexport let two = 2;\n",
    )
    assert "say(one$0(), two$0);" in text


def test_a_name_that_is_not_exported_is_refused():
    with pytest.raises(ValueError, match=r"main\.js imports 'no' of a\.js, which does not export it"):
        script(main='import { no } from "./a.js";\n', a="const no = 1;\n")


def test_what_is_exported_again_is_the_first_modules():
    both = joined(
        {
            "main.js": 'import { ask } from "./source.js";\nask();\n',
            "source.js": 'export { ask } from "./socket.js";\n',
            "socket.js": "export const ask = 1;\n",
        }
    )
    assert both.script == "const ask$0 = 1;\nask$0();\nexport { ask$0 };\n"
    assert both.facades["source.js"] == 'export { ask$0 as ask } from "./page.js";\n'


# --- the page


def test_the_page_needs_one_script_which_has_each_module_that_main_reaches():
    page, text = answer().body.decode(), answer("/page.js").body.decode()
    assert re.findall(r'(?:src|rel="stylesheet" href)="([^"]+)"', page) == ["page.js"]
    found, waiting = set(), ["main.js"]
    while waiting:
        name = waiting.pop()
        if name in found:
            continue
        found.add(name)
        module = (WEB / name).read_text("utf-8")
        waiting += re.findall(r'(?:from|import)\s*\(?\s*"\./([a-z]+\.js)"', module)
        for each in re.findall(
            r"^export (?:async )?(?:function|class|const|let) (\w+)", module, re.MULTILINE
        ):
            final = re.search(rf"(\w+\$\d+) as {each}[ ,]", answer(f"/{name}").body.decode())
            assert final is not None, (name, each)
            assert final[1] in text.rpartition("export {")[2]
    assert found == {each.name for each in WEB.iterdir() if each.name.endswith(".js")} - {"embedded.js"}
    assert "import" not in re.findall(r"^\w+", text, re.MULTILINE)


def test_the_policy_allows_the_style_within_the_page_and_no_other():
    page = answer()
    (style,) = re.findall(r"<style>(.*?)</style>", page.body.decode(), re.DOTALL)
    assert style == (WEB / "watch.css").read_text("utf-8")
    digest = b64encode(sha256(style.encode()).digest()).decode()
    assert f"style-src 'self' 'sha256-{digest}'; img-src" in page.headers["Content-Security-Policy"]
    assert "style-src 'self'; " in answer("/page.js").headers["Content-Security-Policy"]


@pytest.mark.parametrize("path", ["/", "/page.js", "/icon.svg"])
def test_a_browser_that_reads_gzip_gets_the_same_bytes_packed(path):
    plain, packed = answer(path), answer(path, accepts="br, gzip;q=0.8")
    assert "Content-Encoding" not in plain.headers
    assert packed.headers["Content-Encoding"] == "gzip"
    assert packed.headers["Content-Length"] == str(len(packed.body))
    assert gzip.decompress(packed.body) == plain.body
    assert plain.headers["ETag"] != packed.headers["ETag"]


@pytest.mark.parametrize("accepts", ["", "br", "identity", "gzip;q=0", "gzip; q=0.0", "*;q=0"])
def test_a_browser_that_does_not_read_gzip_gets_none(accepts):
    assert "Content-Encoding" not in answer(accepts=accepts).headers


def test_what_a_browser_has_already_is_not_sent_again():
    first = answer("/page.js", accepts="gzip")
    again = answer("/page.js", accepts="gzip", cached=f'"other", W/{first.headers["ETag"]}')
    assert (again.status, again.body) == (304, b"")
    assert answer("/page.js", accepts="gzip", cached='"other"').status == 200
    assert answer("/", accepts="gzip", cached=first.headers["ETag"]).status == 200


def test_the_first_picture_takes_less_than_100_kb():
    assert sum(len(answer(path, accepts="gzip").body) for path in ("/", "/page.js")) < 100_000


def test_no_line_of_a_module_is_over_120_characters():
    found = {
        f"{each.name}:{number}": len(line)
        for each in WEB.iterdir()
        if each.name.endswith((".js", ".css"))
        for number, line in enumerate(each.read_text("utf-8").splitlines(), 1)
        if len(line) > 120
    }
    assert found == {}
