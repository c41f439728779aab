"""The product works from a wheel, an editable install and a checkout, from any folder.

A wheel that is built from the sdist has the same files, byte by byte, as the wheel of the checkout.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import sysconfig
import tarfile
import venv
import zipfile
from pathlib import Path

import pytest

from .. import needs

ROOT = Path(__file__).resolve().parents[2]
FORMS = ["wheel", "editable", "checkout"]
CONTENT = ("planners", "rules", "robots", "scenarios")
DATA = (  # of each kind that no import asks for
    "py.typed",
    "_content/robots/pioneer_p3dx/robot.xml",
    "_content/robots/pioneer_p3dx/identified.toml",
    "_content/robots/summit_xl/encounter.py",
    "_content/scenarios/exp1.toml",
    "_content/scenarios/families/barn_like.py",
    "cli/project/README.md",
    "compare/report/templates/comparison.html",
    "knowledge/schema/world.toml",
    "compare/report/templates/report.css",
    "studio/web/app.js",
    "studio/web/page.html",
    "studio/web/studio.css",
)

needs.package("build", "hatchling")


def do(*command: str | Path, cwd: Path | None = None, **environment: str) -> str:
    clean = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "PYTHONHOME")}
    done = subprocess.run(command, cwd=cwd, env={**clean, **environment}, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def files_below(root: Path, folder: str) -> list[str]:
    """What is kept in a folder, with the folder's name; not what is made there."""
    paths = (p for p in (root / folder).rglob("*") if p.is_file() and p.suffix not in (".pyc", ".so"))
    return [p.relative_to(root).as_posix() for p in paths]


@pytest.fixture(scope="session")
def built(tmp_path_factory) -> dict[str, Path]:
    """The sdist, and a wheel from the checkout and one from the sdist."""
    direct, both = tmp_path_factory.mktemp("direct"), tmp_path_factory.mktemp("both")
    do(sys.executable, "-m", "build", "--no-isolation", "--wheel", "--outdir", direct, ROOT)
    do(sys.executable, "-m", "build", "--no-isolation", "--outdir", both, ROOT)
    (wheel,), (from_sdist,), (sdist,) = direct.glob("*.whl"), both.glob("*.whl"), both.glob("*.tar.gz")
    return {"wheel": wheel, "wheel from sdist": from_sdist, "sdist": sdist}


@pytest.fixture(scope="session")
def dependencies(tmp_path_factory) -> Path:
    """A folder with all that is installed here but rocs_bt itself."""
    folder = tmp_path_factory.mktemp("dependencies")
    for path in Path(sysconfig.get_path("purelib")).iterdir():
        if path.suffix != ".pth" and not path.name.lower().startswith(("rocs_bt", "_rocs_bt", "__editable__")):
            (folder / path.name).symlink_to(path, target_is_directory=path.is_dir())
    return folder


@pytest.fixture(scope="session", params=FORMS)
def command(request, built, dependencies, tmp_path_factory) -> tuple[list[str | Path], dict[str, str]]:
    """What stands for `rocs-bt` in a clean environment that has the dependencies but no other rocs_bt."""
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, symlinks=os.name != "nt")
    python = folder / ("Scripts" if os.name == "nt" else "bin") / "python"
    scripts = python.parent
    paths = do(python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))").strip()
    (Path(paths) / "dependencies.pth").write_text(str(dependencies))
    if request.param == "checkout":
        return [python, "-m", "rocs_bt"], {"PYTHONPATH": str(ROOT)}
    what = ["--editable", ROOT] if request.param == "editable" else [built[request.param]]
    pip = [sys.executable, "-m", "pip", "--python", python, "install", "--quiet", "--no-deps", "--no-index"]
    do(*pip, "--no-build-isolation", "--disable-pip-version-check", *what)
    return [scripts / "rocs-bt"], {}


def test_all_content_is_found_from_another_folder(command, tmp_path):
    arguments, environment = command
    entries = json.loads(do(*arguments, "list", "--json", cwd=tmp_path, **environment))
    found = {(e["kind"], e["name"]) for e in entries}
    assert {
        ("scenario", "exp1"),
        ("robot", "pioneer_p3dx"),
        ("mission", "go_to"),
        ("rules", "avoid_collision"),
    } <= found
    assert all(Path(e["path"]).is_file() and e["doc"] for e in entries)


def test_exp1_runs_from_another_folder(command, tmp_path):
    arguments, environment = command
    out = do(*arguments, "run", "exp1", "--json", cwd=tmp_path, **environment)
    summary = json.loads(out)
    assert summary["agents"]["R2"]["outcome"] == "success"
    written = {p.name for p in (tmp_path / "runs" / "exp1-1").iterdir()}
    assert {"summary.json", "run.mcap", "report.html"} <= written


def test_the_wheels_are_the_same_and_carry_content_and_licence(built):
    wheels = [zipfile.ZipFile(built[form]) for form in ("wheel", "wheel from sdist")]
    names = [sorted(wheel.namelist()) for wheel in wheels]
    assert names[0] == names[1]
    compiled = {name for name in names[0] if name.endswith((".so", "/RECORD"))}  # the kernel knows its build folder
    assert len(compiled) <= 2
    assert [n for n in names[0] if n not in compiled and wheels[0].read(n) != wheels[1].read(n)] == []
    content = {f"rocs_bt/_content/{name}" for folder in CONTENT for name in files_below(ROOT, folder)}
    assert content | set(files_below(ROOT, "rocs_bt")) <= set(names[0])
    for wanted in DATA:
        assert f"rocs_bt/{wanted}" in names[0]
    assert any(n.endswith("licenses/LICENSE") for n in names[0])
    assert not [n for n in names[0] if n.startswith("tests/") or "__pycache__" in n]


def test_wheels_and_sdist_carry_the_manual(built):
    needs.package(*needs.MANUAL)
    with tarfile.open(built["sdist"]) as archive:
        names = archive.getnames()
    assert any(n.endswith("/rocs_bt/_manual/index.html") for n in names)
    for form in ("wheel", "wheel from sdist"):
        assert "rocs_bt/_manual/index.html" in zipfile.ZipFile(built[form]).namelist()
    assert built["wheel"].stat().st_size + built["sdist"].stat().st_size <= 8e6


def test_docs_finds_the_manual_of_an_installation(command, request, tmp_path):
    needs.package(*needs.MANUAL)
    arguments, environment = command
    if "wheel" not in request.node.name:
        pytest.skip("a checkout has no manual before `make docs`")
    page = Path(do(*arguments, "docs", "--path", cwd=tmp_path, **environment).strip())
    assert page.parts[-3:] == ("rocs_bt", "_manual", "index.html")
    assert "rocs_bt" in page.read_text("utf-8")


def test_the_sdist_carries_nothing_that_was_made(built):
    with tarfile.open(built["sdist"]) as archive:
        names = archive.getnames()
    assert not [n for n in names if "/runs/" in n or "__pycache__" in n or "/.venv/" in n]
