"""`lag new`: a project of one's own, with a part, a scene, a test and a line for CI."""

import math
import re
from argparse import Namespace
from pathlib import Path

from lagrangia.base.diagnostics import fail
from lagrangia.base.result_files import write_text
from lagrangia.language.classes import BUILTIN_TYPES
from lagrangia.language.component_library import library

_PARTS = '''\
model SofteningSpring "Its force is k stretch/(1 + (stretch/s0)^2)"
  parameter Stiffness k "for small stretches";
  parameter Length s0 "stretch at which the force is half of that";
  extends Elastic;
energy
  potential k*s0^2/2*log(1 + (stretch/s0)^2);
drawing
  zigzag(a, b, of = stretch, label = k);
end SofteningSpring;
'''
_SCENE = '''\
import "parts.lag";

model {model} "A block on a spring that gives way"
  parameter Mass m = 1 "of the block";
  Block block(m = m, base = world, s(start = 0.2), v(start = 0));
  SofteningSpring spring(k = 4, s0 = 0.1, stretch = block.s);
  output Force pull = -m*der(block.v) "of the spring";
  annotation(experiment(StopTime = 10, Tolerance = 1e-8));
end {model};
'''
_TESTS = '''\
import "../parts.lag";

model TestSmallStretch "While it is short of s0, the spring is linear: s = 0.1 cos(2 t), which TestSmallStretch.csv holds"
  Block block(m = 1, base = world, s(start = 0.1), v(start = 0));
  SofteningSpring spring(k = 4, s0 = 300, stretch = block.s);
  annotation(experiment(StopTime = 5, Tolerance = 1e-8));
end TestSmallStretch;
'''
_README = '''\
# {name}

```sh
lag simulate {name}.lag --plot {name}.png    # the motion
lag draw {name}.lag                          # the scene as a picture
lag doc *.lag -o site                        # pages of the parts
lag test                                     # tests/*.lag: each model against the table of its name
```

A line for CI, which ends with an exit code of its own for what is wrong:

```sh
pip install lagrangia && lag format --check . && lag lint *.lag && lag test
```
'''


def new_command(options: Namespace) -> int:
    """Writes the files into a new folder. Raises LagError L0004, L0706."""
    folder = Path(options.folder)
    name = folder.name
    if not re.fullmatch(r"[A-Za-z]\w*", name):
        fail("L0706", f"'{name}' is no name for a project", None, "letters, digits and _, a letter first: lag new swing")
    if folder.exists():
        fail("L0004", f"'{folder}' exists", None, "choose another name")
    model = "".join(part[:1].upper() + part[1:] for part in name.split("_"))
    if name == "parts" or model in _taken():
        fail("L0706", f"'{name}' is the name of something else: its model would be {model}", None, f"lag new my_{name.lower()}")
    rows = "".join(f"{t:g},{0.1 * math.cos(2 * t)!r}\n" for t in (k / 2 for k in range(11)))
    texts = {f"{name}.lag": _SCENE.format(model=model), "parts.lag": _PARTS, "README.md": _README.format(name=name),
             "tests/tests.lag": _TESTS, "tests/TestSmallStretch.csv": f"time,block.s\n{rows}"}
    for place, text in texts.items():
        (folder / place).parent.mkdir(parents=True, exist_ok=True)
        write_text(folder / place, text)
    print(f"{folder}: {', '.join(texts)}\nnext: cd {folder} && lag test && lag simulate {name}.lag")
    return 0


def _taken() -> set[str]:
    """Names of classes that are there already, and of those that a project begins with."""
    return {c.name for file in library() for c in file.classes} | BUILTIN_TYPES | {"SofteningSpring"}
