"""Long chains whose links are stamped out are the chains whose links are derived one by one."""

from pathlib import Path

import pytest

from lagrangia.algebra import scans
from lagrangia.base.diagnostics import LagError
from lagrangia.compile.pipeline import compile_file
from lagrangia.frames import stamped_poses
from lagrangia.run.scene import Scene, to_json

LINKS = """Revolute hinge[30]; Bar link[30](m = {1 + 0.1*i for i in 1:30}, each L = 0.5);
"""
JOINED = """connect(world, hinge[1].a);
  for i in 1:30 loop connect(hinge[i].b, link[i].a); end for;
  for i in 1:29 loop connect(link[i].b, hinge[i + 1].a); end for;
"""
CHAINS = {
    "open": f"{LINKS}equation\n{JOINED}",
    "with what hangs on it": f"""{LINKS}PointMass bob[6](each m = 1); Revolute at[6](a = link[3:8].b);
equation\n{JOINED} for i in 1:6 loop bob[i].center = shift(at[i].b, {{0, -0.3}}); end for;""",
    "two from one link": f"""{LINKS}Revolute other[28]; Disc disc[28](each m = 1, each r = 0.1);
equation\n{JOINED} connect(link[2].b, other[1].a);
  for i in 1:28 loop disc[i].center = shift(other[i].b, {{0.2, 0.01}}); end for;
  for i in 1:27 loop connect(disc[i].center, other[i + 1].a); end for;""",
    "of slides and hinges": """Prismatic slide[26](each along = {0.6, 0.8}); Revolute hinge[26];
  Disc disc[26](each m = 1, each r = 0.1);
  Spring spring[26](each k = 10, stretch = {slide[i].s for i in 1:26});
equation
  connect(world, slide[1].a);
  for i in 1:26 loop connect(slide[i].b, hinge[i].a); connect(hinge[i].b, disc[i].center); end for;
  for i in 1:25 loop connect(disc[i].center, slide[i + 1].a); end for;""",
    "on a support that moves": f"{LINKS}equation\n{JOINED.replace('world', 'shift(world, {0.1*sin(2[rad/s]*time), 0})')}",
}


def scene_of(text: str, folder: Path) -> Scene:
    path = folder / "chain.lag"
    path.write_text(f"model Chain\n  {text}\nend Chain;\n", encoding="utf-8")
    return compile_file(path).scene


@pytest.mark.parametrize("name", CHAINS)
def test_links_that_are_stamped_out_are_those_derived_one_by_one(name: str, tmp_path: Path,
                                                                 monkeypatch: pytest.MonkeyPatch) -> None:
    stamped = scene_of(CHAINS[name], tmp_path)
    monkeypatch.setattr(scans, "_FEWEST", 1000)
    monkeypatch.setattr(stamped_poses, "FEWEST", 1000)
    assert to_json(stamped) == to_json(scene_of(CHAINS[name], tmp_path))


def test_momenta_of_a_long_chain_are_made_where_one_moves_no_mass_or_somebody_asks(tmp_path: Path) -> None:
    chain = """Revolute hinge[301]; Bar link[301](each m = 1, each L = 0.5);
equation
  connect(world, hinge[1].a);
  for i in 1:301 loop connect(hinge[i].b, link[i].a); end for;
  for i in 1:300 loop connect(link[i].b, hinge[i + 1].a); end for;"""
    path = tmp_path / "chain.lag"
    path.write_text(f"model Chain\n  {chain}\nend Chain;\n", encoding="utf-8")
    motion = compile_file(path).run
    assert not motion.momenta.is_known and motion.momentum.numel() == 301
    text = f"model Chain\n  Revolute loose;\n  {chain}\n  connect(link[301].b, loose.a);\nend Chain;\n"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(LagError, match=r"'loose\.phi' moves no mass"):
        compile_file(path)
