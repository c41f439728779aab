"""The rules' kernel is built where there is a C compiler, and left out in silence where there is none."""

import importlib.util
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from rocs_bt.expression import kernel_missing

from .. import needs

ROOT = Path(__file__).resolve().parents[2]
BINARY = "rocs_bt/expression/_kernel.abi3.so"

needs.package("build", "hatchling")


@pytest.fixture(scope="module")
def hook():
    spec = importlib.util.spec_from_file_location("hatch_build", ROOT / "hatch_build.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def wheel(folder, monkeypatch, compiler):
    monkeypatch.setenv("CC", str(compiler))
    monkeypatch.setenv("ROCS_BT_NO_MANUAL", "1")
    command = [sys.executable, "-m", "build", "--no-isolation", "--wheel", "--outdir", folder, ROOT]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    (made,) = folder.glob("*.whl")
    return made.name, zipfile.ZipFile(made).namelist()


@pytest.fixture(scope="module")
def kernel(hook, tmp_path_factory):
    """The kernel, compiled here."""
    made = tmp_path_factory.mktemp("kernel") / "kernel.so"
    if reason := hook.compile_kernel(ROOT / hook.SOURCE, made):
        pytest.skip(f"the C kernel cannot be compiled here: {reason}")
    return made


@pytest.mark.usefixtures("kernel")
def test_where_it_compiles_it_was_built_and_serves():
    assert kernel_missing() == ""


def test_only_the_module_is_seen_from_outside(kernel):
    """Names such as `step` would be taken for those of other libraries."""
    nm = needs.program("nm", "lists the names of a library")
    done = subprocess.run([nm, "-D", "--defined-only", kernel], capture_output=True, text=True)
    names = {line.split()[-1].lstrip("_") for line in done.stdout.splitlines()}
    seen = {name for name in names if name not in ("init", "fini", "bss_start", "edata", "end")}
    assert seen == {"PyInit__kernel"}


@pytest.mark.usefixtures("kernel")
def test_a_wheel_with_it_is_of_this_platform(hook, tmp_path, monkeypatch):
    name, files = wheel(tmp_path, monkeypatch, " ".join(hook._compiler()))
    assert "-cp311-abi3-" in name
    assert "-any.whl" not in name
    assert BINARY in files


def test_a_compiler_that_fails_leaves_it_out(tmp_path, monkeypatch):
    name, files = wheel(tmp_path, monkeypatch, "false")
    assert name.endswith("-py3-none-any.whl")
    assert BINARY not in files


def test_no_compiler_leaves_it_out(hook, tmp_path, monkeypatch):
    monkeypatch.setenv("CC", str(tmp_path / "no-such-compiler"))
    assert "compiler" in hook.compile_kernel(ROOT / hook.SOURCE, tmp_path / "kernel.so")
