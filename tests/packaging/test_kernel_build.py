"""The kernels are built where there is a C compiler, and left out in silence where there is none."""

import importlib.util
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from rocs_bt.compiled import PLAIN
from rocs_bt.geometry import arc_positions
from rocs_bt.reactive.kernel_backend import kernel_missing

ROOT = Path(__file__).resolve().parents[2]
BINARIES = {"rocs_bt/reactive/_kernel.abi3.so", "rocs_bt/_numbers.abi3.so"}

pytest.importorskip("build", reason="building needs the test extra")
pytest.importorskip("hatchling", reason="building needs the test extra")


@pytest.fixture(scope="module")
def hook():
    spec = importlib.util.spec_from_file_location("hatch_build", ROOT / "hatch_build.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def wheel(folder, monkeypatch, compiler):
    monkeypatch.setenv("CC", str(compiler))
    command = [sys.executable, "-m", "build", "--no-isolation", "--wheel", "--outdir", folder, ROOT]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    (made,) = folder.glob("*.whl")
    return made.name, zipfile.ZipFile(made).namelist()


@pytest.fixture(params=["_kernel", "_numbers"])
def source(request, hook):
    (found,) = (ROOT / source for source in hook.SOURCES if source.stem == request.param)
    return found


def test_where_they_compile_they_were_built_and_serve(hook, source, tmp_path):
    if reason := hook.compile_kernel(source, tmp_path / "kernel.so"):
        pytest.skip(f"it cannot be compiled here: {reason}")
    assert kernel_missing() == ""
    assert arc_positions is not PLAIN["arc_positions"]


def test_only_the_module_is_seen_from_outside(hook, source, tmp_path):
    """Names such as `step` would be taken for those of other libraries."""
    if reason := hook.compile_kernel(source, tmp_path / "kernel.so"):
        pytest.skip(f"it cannot be compiled here: {reason}")
    try:
        done = subprocess.run(["nm", "-D", "--defined-only", tmp_path / "kernel.so"], capture_output=True, text=True)
    except OSError:
        pytest.skip("there is no nm")
    names = {line.split()[-1].lstrip("_") for line in done.stdout.splitlines()}
    seen = {name for name in names if name not in ("init", "fini", "bss_start", "edata", "end")}
    assert seen == {f"PyInit_{source.stem}"}


def test_a_wheel_with_them_is_of_this_platform(hook, source, tmp_path, monkeypatch):
    if reason := hook.compile_kernel(source, tmp_path / "kernel.so"):
        pytest.skip(f"it cannot be compiled here: {reason}")
    (folder := tmp_path / "wheel").mkdir()
    name, files = wheel(folder, monkeypatch, " ".join(hook._compiler()))
    assert "-cp311-abi3-" in name
    assert "-any.whl" not in name
    assert set(files) >= BINARIES


def test_a_compiler_that_fails_leaves_them_out(tmp_path, monkeypatch):
    name, files = wheel(tmp_path, monkeypatch, "false")
    assert name.endswith("-py3-none-any.whl")
    assert not BINARIES & set(files)


def test_no_compiler_leaves_it_out(hook, source, tmp_path, monkeypatch):
    monkeypatch.setenv("CC", str(tmp_path / "no-such-compiler"))
    assert "compiler" in hook.compile_kernel(source, tmp_path / "kernel.so")
