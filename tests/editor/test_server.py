"""`lag server`, driven through its pipes by the protocol, as an editor drives it."""

import json
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from helpers.language_client import Client
from lagrangia.editor.formatting import formatted
from lagrangia.editor.outline import MODIFIERS, TOKENS

pytest.importorskip("pygls")
PARTS = """model Leg "one of several"
  parameter Length L = 0.5 "how long";
  Frame hip, foot;
equation
  foot = shift(hip, {0, -L});
end Leg;
"""
SCENE = """import "parts.lag";
// ü𝄞 stand for two and four bytes
model Swing "a swing"
  parameter Length L = 2 "length";
  parameter Mass m = 3*L/1[m]*1[kg];
  Revolute hinge(a = world, phi(start = 1));
  Bar bar(m = m, L = L, a = hinge.b);
  Spring s(k = 3, a = world, b = bar.center);
  Leg leg(L = 0.25);
  output Length y = bar.b.y + leg.foot.y;
equation
  for i in 1:1 loop
    leg.hip = shift(bar.a, {L*i, 0});
  end for;
end Swing;
"""
ALL = {"start": {"line": 0, "character": 0}, "end": {"line": 99, "character": 0}}


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Client]:
    folder = tmp_path_factory.mktemp("project")
    (folder / "parts.lag").write_text(PARTS)
    client = Client(folder)
    yield client
    assert client.close() == 0 and "Traceback" not in client.written, "requests that are refused are answered alone"


@pytest.fixture(scope="module")
def scene(client: Client) -> str:
    uri, wrong = client.open("swing.lag", SCENE)
    assert wrong == []
    return uri


def labels(items: list[dict]) -> list[str]:
    return [item["label"] for item in items]


def texts(text: str, found: list[dict]) -> list[str]:
    """What stands at these places; all of them are in one line."""
    lines = text.split("\n")
    return [lines[r["start"]["line"]][r["start"]["character"] : r["end"]["character"]] for r in found]


def test_what_is_told_of_names(client: Client, scene: str) -> None:
    told = client.at("hover", scene, SCENE, "k = 3")["contents"]["value"]
    assert "parameter Stiffness k" in told and "unit N/m" in told and "value 3 N/m" in told and "springs.lag" in told
    told = client.at("hover", scene, SCENE, "m = 3*L")["contents"]["value"]
    assert "default 3*L/1[m]*1[kg]" in told and "value 6 kg" in told
    told = client.at("hover", scene, SCENE, "Bar bar")["contents"]["value"]
    assert "Straight rigid uniform bar" in told and "`Length L` [m]: length" in told
    assert client.at("hover", scene, SCENE, "// ü") is None


def test_definitions_are_found_also_in_the_library_and_in_other_files(client: Client, scene: str) -> None:
    library = client.at("definition", scene, SCENE, "Spring s")
    assert library["uri"].endswith("/models/library/springs.lag") and library["range"]["start"]["line"] > 0
    assert client.at("definition", scene, SCENE, "Leg leg")["uri"].endswith("/parts.lag")
    hip = client.at("definition", scene, SCENE, "hip")
    assert hip["uri"].endswith("/parts.lag") and hip["range"]["start"] == {"line": 2, "character": 8}
    iterator = client.at("definition", scene, SCENE, "i, 0}")
    assert texts(SCENE, [iterator["range"]]) == ["i"] and iterator["range"]["start"]["character"] == 6


def test_references_and_other_names(client: Client, scene: str) -> None:
    found = client.at("references", scene, SCENE, "L = 2", context={"includeDeclaration": True})
    assert [place["range"]["start"]["line"] for place in found] == [3, 4, 6, 12]
    assert texts(SCENE, [place["range"] for place in found]) == ["L"] * 4
    across = client.at("references", scene, SCENE, "L = 0.25", context={"includeDeclaration": True})
    assert sorted(place["uri"].rpartition("/")[2] for place in across) == ["parts.lag", "parts.lag", "swing.lag"]
    edit = client.at("rename", scene, SCENE, "L = 0.25", newName="length")["changes"]
    assert {uri.rpartition("/")[2]: len(edits) for uri, edits in edit.items()} == {"parts.lag": 2, "swing.lag": 1}
    for name, why in (("m", "there is a 'm' already"), ("1x", "cannot be a name"), ("end", "cannot be a name")):
        with pytest.raises(ValueError, match=why):
            client.at("rename", scene, SCENE, "L = 2", newName=name)
    with pytest.raises(ValueError, match="of the library"):
        client.at("rename", scene, SCENE, "Spring s", newName="Feder")


def test_completion(client: Client, scene: str) -> None:
    assert labels(client.at("completion", scene, SCENE, "k = 3")) == ["k", "s_rel0", "a", "b", "stretch"]
    assert "m" in labels(client.at("completion", scene, SCENE, "bar.b.y", 4))
    attributes = {"r", "x", "y", "z", "phi", "R", "Q", "v", "w", "omega"}
    assert set(labels(client.at("completion", scene, SCENE, "bar.b.y", 6))) == attributes
    assert {"start", "fixed"} <= set(labels(client.at("completion", scene, SCENE, "start = 1")))
    assert {"parameter", "Leg", "Spring", "Length"} <= set(labels(client.at("completion", scene, SCENE, "Spring s")))
    assert {"kg", "mm", "N"} & set(labels(client.at("completion", scene, SCENE, "m]*1", 0)))
    assert {"shift", "bar", "world"} <= set(labels(client.at("completion", scene, SCENE, "shift(")))
    assert "model" in labels(client.at("completion", scene, SCENE, "// ü", 0))


def test_completion_in_texts_that_are_being_written(client: Client) -> None:
    half = SCENE.replace("Spring s(k = 3, a = world, b = bar.center);", "Spring s(")
    uri, wrong = client.open("half.lag", half)
    assert wrong
    assert "s_rel0" in labels(client.at("completion", uri, half, "Spring s(", 9))
    half = half.replace("Spring s(", "Real z = bar.")
    client.change(uri, half, 2)
    assert "center" in labels(client.at("completion", uri, half, "Real z = bar.", 13))
    half = half.replace("Real z = bar.", "Real z = bar.center.")
    client.change(uri, half, 3)
    assert "phi" in labels(client.at("completion", uri, half, "bar.center.", 11))


def test_texts_that_nobody_writes(client: Client) -> None:
    """Letters that are half of one ended in an error; words of a million letters took minutes, and names longer than files have
    one, too."""
    text = 'model M "\ud800"\n  PointMass p(m = 1) "\udc01"; Real y = p.' + "x" * 200_000 + ".z;\nend M;\n"
    uri, _ = client.open("odd.lag", text)
    assert client.at("hover", uri, text, "PointMass")
    assert "center" in labels(client.at("completion", uri, text, "p.x", 2))
    assert isinstance(client.at("completion", uri, text, ".z", 0), list)


def test_completion_where_the_end_of_a_class_lacks(client: Client) -> None:
    """Nothing was proposed there, after a second."""
    text = SCENE.replace("end Swing;\n", "")
    uri, (found,) = client.open("endless.lag", text)
    assert "ends too early" in found["message"] and "center" in labels(client.at("completion", uri, text, "bar.center", 4))
    others = (text.replace("  output", "model Part\n  output"), text + "end Swang;\n", text + "  leg.hip = bar.",
              text.replace("equation\n", "  Real z = bar.\nequation\n"))
    for version, other in enumerate(others, 2):
        assert client.change(uri, other, version)[0]
        assert "center" in labels(client.at("completion", uri, other, "bar.\n" if "bar.\n" in other else "bar.center", 4))



DRIVE = """model Drive
  Rotational.Inertia i(J = 1, w(start = 3)), j(J = 2);
equation
  connect(i.flange_b, j.flange_a);
end Drive;
"""


def test_completion_where_shafts_are_connected(client: Client) -> None:
    """Names, whole or broken off at the end of a class; what has no frames has no reaction."""
    uri, wrong = client.open("drive.lag", DRIVE)
    assert wrong == [] and {"i", "j"} <= set(labels(client.at("completion", uri, DRIVE, "j.flange_a")))
    assert "flange_a" in (found := labels(client.at("completion", uri, DRIVE, "i.flange_b", 2))) and "reaction" not in found
    broken = DRIVE.replace("j.flange_a);", "")
    assert client.change(uri, broken, 2)[0]
    found = labels(client.at("completion", uri, broken, "flange_b, ", 10))
    assert {"i", "j"} <= set(found) and "nominal" not in found


def test_signatures(client: Client, scene: str) -> None:
    shown = client.at("signatureHelp", scene, SCENE, "k = 3", 4)
    assert shown["signatures"][0]["label"] == "Spring(k, s_rel0, a, b, stretch)"
    assert shown["activeParameter"] == 0 and "[N/m]" in shown["signatures"][0]["parameters"][0]["documentation"]
    assert client.at("signatureHelp", scene, SCENE, "model Swing") is None


def test_outline_folds_hints_and_tokens(client: Client, scene: str) -> None:
    document = {"uri": scene}
    (model,) = client.ask("textDocument/documentSymbol", textDocument=document)
    assert model["name"] == "Swing" and labels([{"label": c["name"]} for c in model["children"]])[:3] == ["L", "m", "hinge"]
    folds = client.ask("textDocument/foldingRange", textDocument=document)
    assert {(fold["startLine"], fold["endLine"]) for fold in folds} == {(2, 14), (10, 13), (11, 13)}
    hints = client.ask("textDocument/inlayHint", textDocument=document, range=ALL)
    assert [hint["label"] for hint in hints] == ["m", "rad", "N/m", "m"]
    data = client.ask("textDocument/semanticTokens/full", textDocument=document)["data"]
    line = column = 0
    named = {}
    for step, along, length, kind, modifiers in zip(*[iter(data)] * 5, strict=True):
        line, column = line + step, along + (0 if step else column)
        text = SCENE.split("\n")[line][column : column + length]
        named[text] = TOKENS[kind], {name for k, name in enumerate(MODIFIERS) if modifiers >> k & 1}
    assert named["Spring"] == ("class", {"defaultLibrary"}) and named["Length"][0] == "type" and named["m"][0] == "parameter"
    assert named["Leg"] == ("class", set()) and named["i"][0] == "variable"


def test_diagnostics_with_fixes(client: Client) -> None:
    text = SCENE.replace("k = 3", "kk = 3").replace("m = m, L = L", "m = m, LL = L")
    uri, wrong = client.open("wrong.lag", text)
    assert {found["code"] for found in wrong} == {"L0203"}
    actions = client.ask("textDocument/codeAction", textDocument={"uri": uri}, range=ALL, context={"diagnostics": wrong})
    assert [action["title"] for action in actions] == ["write 'L'", "write 'k'"]
    for action in actions:
        (edit,) = action["edit"]["changes"][uri]
        lines = text.split("\n")
        place = edit["range"]
        row = lines[place["start"]["line"]]
        lines[place["start"]["line"]] = row[: place["start"]["character"]] + edit["newText"] + row[place["end"]["character"] :]
        text = "\n".join(lines)
    assert text == SCENE and client.change(uri, text, 2)[0] == []
    missing, _ = client.change(uri, SCENE.replace("L = L, a = hinge.b);", "L = L, a = hinge.b)"), 3)
    (action,) = client.ask("textDocument/codeAction", textDocument={"uri": uri}, range=ALL, context={"diagnostics": missing})
    assert action["title"] == "write ';'"


def test_formatting(client: Client) -> None:
    text = "model M Real   x=1; end M;"
    uri, _ = client.open("cramped.lag", text)
    (edit,) = client.ask("textDocument/formatting", textDocument={"uri": uri}, options={"tabSize": 4, "insertSpaces": True})
    assert edit["newText"] == "model M\n  Real x = 1;\nend M;\n"
    client.change(uri, "model M Real", 2)
    assert client.ask("textDocument/formatting", textDocument={"uri": uri}, options={"tabSize": 4, "insertSpaces": True}) == []


def test_a_saved_text_is_asked_for_by_all_phases(client: Client) -> None:
    text = "model M\n  Spring s(k = 1, a = world);\n  Block b(m = 1, base = world);\nend M;\n"
    uri, wrong = client.open("loose.lag", text)
    assert wrong == []
    (client.folder / "loose.lag").write_text(text)
    client.tell("textDocument/didSave", textDocument={"uri": uri})
    (found,) = client.diagnostics(uri)
    assert found["code"].startswith("L04") and "'b' of Spring 's'" in found["message"]


def test_parts_may_leave_values_and_ports_open(client: Client) -> None:
    text = "model Part\n  parameter Stiffness k;\n  Frame a;\n  Spring s(a = a, b = world);\nend Part;\n"
    _, wrong = client.open("part.lag", text)
    assert [found["message"].splitlines()[0] for found in wrong] == ["Spring 's' needs a value for its parameter 'k' (stiffness)"]
    uri, wrong = client.open("whole_part.lag", text.replace("s(", "s(k = k, "))
    assert wrong == []
    run = text.replace("s(", "s(k = k, ").replace("end", "  annotation(experiment(StopTime = 1));\nend")
    assert [found["code"] for found in client.change(uri, run, 2)[0]] == ["L0211"]


def test_500_lines_are_looked_at_within_a_tenth_of_a_second(client: Client) -> None:
    """Of processor time, measured 0.04 s; the bound leaves room for busy machines."""
    parts = "".join(f"  Revolute h{k}(a = {f'b{k - 1}.b' if k else 'world'});\n  Bar b{k}(m = 1, L = 1, a = h{k}.b);\n"
                    for k in range(125))
    rest = "".join(f"  parameter Length x{k} = {k};\n  output Length y{k} = b{k}.b.y + x{k};\n" for k in range(124))
    text = f"model Big\n{parts}{rest}end Big;\n"
    assert text.count("\n") == 500
    uri, _ = client.open("big.lag", text)
    before = client.processor_seconds()
    assert all(client.change(uri, text.replace("x77", f"z{k}"), k + 2)[0] == [] for k in range(5))
    assert (client.processor_seconds() - before) / 5 < 0.2


def test_without_pygls_a_sentence_says_so(tmp_path: Path) -> None:
    (tmp_path / "pygls.py").write_text("raise ImportError")
    program = f"""import sys; sys.path.insert(0, {str(tmp_path)!r})
from lagrangia.command.cli import main; sys.exit(main(["server"]))"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == 2 and "needs pygls, which is not installed" in done.stderr and "pip install" in done.stderr


VIM = """
local id = vim.lsp.start_client({name = "lag", cmd = {%r, "-m", "lagrangia", "server"}, root_dir = vim.fn.getcwd()})
vim.lsp.buf_attach_client(0, id)
vim.wait(20000, function() return #vim.diagnostic.get(0) > 0 end)
for _, found in ipairs(vim.diagnostic.get(0)) do io.stdout:write("TOLD " .. found.message .. "\\n") end
local params = vim.lsp.util.make_formatting_params({})
local answers = vim.lsp.buf_request_sync(0, "textDocument/formatting", params, 10000)
for _, answer in pairs(answers) do io.stdout:write("FORMATTED " .. tostring(#answer.result) .. "\\n") end
"""


@pytest.mark.skipif(shutil.which("nvim") is None, reason="needs Neovim")
def test_neovim_is_served(tmp_path: Path) -> None:
    (tmp_path / "scene.lag").write_text("model M Spring s(kk = 1); end M;\n")
    (tmp_path / "init.lua").write_text(VIM % sys.executable)
    done = subprocess.run(["nvim", "--headless", "-u", "NONE", "scene.lag", "-c", "luafile init.lua", "-c", "qa!"], cwd=tmp_path,
                          capture_output=True, text=True, timeout=60, check=False)
    said = done.stdout + done.stderr
    assert "TOLD Spring has no parameter or port 'kk'" in said and "FORMATTED 1" in said


def test_what_the_server_lays_out_is_what_the_command_does() -> None:
    """There is one function for both."""
    from lagrangia.editor import server

    assert server.formatted is formatted


def test_messages_that_are_none_end_nothing(tmp_path: Path) -> None:
    """Each is told in a line, what comes behind them is answered, and no text is read that is none."""
    client = Client(tmp_path)
    asked = {"jsonrpc": "2.0", "id": 500, "method": "textDocument/hover"}
    place = {"position": {"line": 0, "character": 0}}
    for content in (b"{", b"\xff", b"[]", b"null", b'{"jsonrpc":"2.0","id":' + b"9" * 5000 + b"}", b"[" * 100_000, b'{"id":{}}',
                    *(json.dumps(asked | {"params": place | {"textDocument": {"uri": uri}}}).encode()
                      for uri in ("file:///dev/zero", "file:///%00", "file:///nowhere.lag", "untitled:1", "http://a/b.lag")),
                    json.dumps(asked | {"params": [1]}).encode()):
        client.process.stdin.write(b"Content-Length: %d\r\n\r\n" % len(content) + content)
    _, found = client.open("a.lag", "model M\n  Block b(m = 1, bass = world);\nend M;\n")
    assert found and client.close() == 0
    assert "Traceback" not in client.written and max(map(len, client.written.splitlines())) <= 300


@pytest.mark.parametrize("size", ["1000000000", "9" * 30])
def test_messages_are_bounded(size: str, tmp_path: Path) -> None:
    done = subprocess.run([sys.executable, "-m", "lagrangia", "server"], input=f"Content-Length: {size}\r\n\r\n{{}}".encode(),
                          capture_output=True, timeout=60, check=False)
    assert done.returncode == 2 and done.stderr.startswith(b"error[L0715]: the editor announces a message of")
