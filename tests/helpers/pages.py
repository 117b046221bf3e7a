"""Pages that compute, without a browser and in one: what they find, and what they tell of themselves."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from lagrangia.play import wasm

BROWSER = shutil.which("chromium") or shutil.which("chromium-browser")
NODE = shutil.which("node")
needs_node = pytest.mark.skipif(wasm.zig() is None or NODE is None, reason="needs zig and Node.js")
needs_browser = pytest.mark.skipif(wasm.zig() is None or BROWSER is None, reason="needs zig and Chromium")
HEADLESS = """
const html = require("fs").readFileSync(process.argv[1], "utf8");
const D = JSON.parse(html.match(/<script id="data" type="application\\/json">(.*?)<\\/script>/s)[1]);
const own = html.match(/<script>\\s*"use strict";(.*)<\\/script>/s)[1].split("const D = JSON")[0];
const made = "const m = await Machine.made(D.program, D.image, D.sizes, D.inputs)";
const script = `return (async () => { ${own}; ${made}; ${process.argv[2]} })()`;
new Function("D", script)(D).then(told => console.log(JSON.stringify(told)));
"""
LISTEN = """<script>
const report = told => {
  const p = document.createElement("pre");
  p.id = "heard"; p.textContent = JSON.stringify(told); document.body.append(p);
};
const pull = (x, y) => {
  const box = $("scene").getBoundingClientRect(), at = box.left + box.width / 2 + (x - view.x(box.width / 2)) * view.k;
  drag({ clientX: at, clientY: box.top + box.height / 2 - (y - view.y(box.height / 2)) * view.k });
};
setInterval(() => {}, 1);  // virtual time does not wait for what is compiled, but passes no faster than its tasks
lagrangia.ready.then(() => {
  const values = [];
  @SCRIPT@
  report({values, faults: window.faults, message: lagrangia.message});
}).catch(e => report({faults: [String(e)]}));
</script></body>"""


def computed(page: Path, script: str) -> dict:
    """What a script finds in the page's machine `m`, without its browser."""
    done = subprocess.run([str(NODE), "-e", HEADLESS, str(page), script], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def heard(page: Path, script: str) -> dict:
    """What a page tells of itself, which takes another attempt where it was looked at before it had compiled."""
    watched = "<head><script>window.faults = []; onerror = e => faults.push(e); " \
              "onunhandledrejection = e => faults.push(String(e.reason));</script>"
    text = page.read_text().replace("<head>", watched)
    page.write_text(text.replace("</body>", LISTEN.replace("@SCRIPT@", script)))
    command = [str(BROWSER), "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={page.parent}/profile",
               "--virtual-time-budget=20000", "--dump-dom", page.as_uri()]
    for _ in range(8):
        dom = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True).stdout
        if found := re.search(r'<pre id="heard">(.*?)</pre>', dom):
            return json.loads(found[1])
    raise AssertionError(dom[-1000:])
