"""Every command of the README does what it says."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w*)\n(.*?)^```$", README, re.DOTALL | re.MULTILINE)  # (language, text)
SHELL = [line for language, text in BLOCKS if language == "sh" for line in text.splitlines()]
SETUP = [line for line in SHELL if line.startswith("python3 -m venv")]
COMMANDS = [line for line in SHELL if line.startswith("lag ")]


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """What commands need of a checkout where the package is installed."""
    shutil.copytree(ROOT / "models", tmp_path / "models")
    return tmp_path


@pytest.fixture
def sources(checkout: Path, tmp_path: Path) -> Path:
    """What installing it needs, too, without anything that was built in it."""
    for name in ("pyproject.toml", "README.md", "LICENSE", "CHANGELOG.md", "grammar", "compiler", "runtime"):
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(source, tmp_path / name)
    return tmp_path


def run(command: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """In bash, with the `lag` of the environment that runs the tests."""
    environment = os.environ | {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    return subprocess.run(["bash", "-c", command], cwd=folder, env=environment, capture_output=True, text=True, check=False)


def test_the_readme_has_two_set_up_commands() -> None:
    assert len(SETUP) == 2
    assert all("\n" not in line for line in SETUP)
    assert len(COMMANDS) >= 6


@pytest.mark.parametrize("command", COMMANDS)
def test_command(command: str, checkout: Path) -> None:
    done = run(command, checkout)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()


@pytest.mark.slow
def test_the_first_set_up_command_makes_the_picture(sources: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The second one is what CI runs. Modules are compiled as they are imported: pip would compile all of all packages."""
    monkeypatch.setenv("PIP_COMPILE", "0")
    monkeypatch.delenv("PYTHONDONTWRITEBYTECODE", raising=False)
    done = run(SETUP[0], sources)
    assert done.returncode == 0, done.stderr
    assert (sources / "suspended_bar.png").stat().st_size > 10_000
    assert (sources / "suspended_bar.csv").read_text().startswith("time,guide.s,tilt.phi,")


def test_python_example(checkout: Path) -> None:
    (code,) = [text for language, text in BLOCKS if language == "python"]
    done = subprocess.run([sys.executable, "-c", code], cwd=checkout, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert (checkout / "chain.png").stat().st_size > 10_000


def test_models_of_the_readme_compile(checkout: Path) -> None:
    """The model blocks are real: they compile as they stand, the components in a scene that uses them."""
    blocks = [text for _, text in BLOCKS if text.startswith("model ")]
    assert len(blocks) == 2
    scene = "model Scene PointMass p(m = 1); SofteningSpring s(a = world, b = p.center, k = 3, s0 = 0.1); end Scene;"
    (checkout / "bar.lag").write_text(blocks[0])
    (checkout / "spring.lag").write_text(blocks[1] + scene)
    done = run("lag check bar.lag spring.lag", checkout)
    assert done.returncode == 0, done.stderr


def test_the_error_shown_is_the_error_given(checkout: Path) -> None:
    (shown,) = [text for _, text in BLOCKS if text.startswith("error[")]
    model = "model Wrong\n  PointMass p(m = 1);\n\n  Spring s(a = world, d = 3, b = p.center);\nend Wrong;\n"
    (checkout / "wrong.lag").write_text(model)
    done = run("lag check wrong.lag", checkout)
    assert done.returncode == 2
    head = [line for line in shown.strip().splitlines() if "-->" not in line]
    assert all(line.strip() in done.stderr for line in head), done.stderr
