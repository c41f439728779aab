"""Benchmarks run to their end and print each row as it comes; their figures are never tested."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).resolve().parent.parent / "benchmarks"
NAMES = sorted(path.stem for path in BENCHMARKS.glob("bench_*.py"))


AWAKE = Path(__file__).with_name("awake.py")
THREADED = ["bench_reflex", "bench_share_loop"]  # an agent on wall time: on a machine that is busy its blocks hang


@pytest.fixture(scope="module")
def printed(tmp_path_factory):
    """By benchmark, the lines that a quick run prints; and the exit codes."""
    folder = tmp_path_factory.mktemp("benchmarks")  # pictures are drawn below the current folder
    lines, codes = {name: [] for name in NAMES}, []
    for command, names in (
        ([BENCHMARKS], [name for name in NAMES if name not in THREADED]),
        ([AWAKE, BENCHMARKS], THREADED),
    ):
        command = [sys.executable, *command, "--quick", *names]
        done = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        codes.append(done.returncode)
        for line in done.stdout.splitlines():
            if (name := line.removesuffix(" ...")) in lines:
                begun = name
            else:
                lines[begun].append(line)
    return lines, codes


@pytest.mark.parametrize("name", NAMES)
def test_a_benchmark_runs_in_its_quick_form(printed, name):
    lines, _ = printed
    assert lines[name], "it printed no row"
    assert not [line for line in lines[name] if line.startswith("Traceback")], "\n".join(lines[name])


def test_a_quick_run_ends_well(printed):
    lines, codes = printed
    assert codes == [0, 0], lines


@pytest.fixture
def folder(tmp_path):
    """A folder of benchmarks: one that waits between two rows, one that raises, one that ends."""
    for shared in ("__main__.py", "row.py"):
        shutil.copy(BENCHMARKS / shared, tmp_path / shared)
    rows = {
        "bench_a": ['yield Row("first", 1.0, "s")', "input()", 'yield Row("second", 2.0, "s")'],
        "bench_b": ['yield Row("before", 3.0, "s")', 'raise KeyError("broken")'],
        "bench_c": ['yield Row("last", size(4.0, 5.0), "s", "another", 0.5, "<= 9 s", True)'],
    }
    for name, body in rows.items():
        text = "\n    ".join(["from row import Row, size\n\ndef run():", *body])
        (tmp_path / f"{name}.py").write_text(text)
    return tmp_path


def test_rows_come_as_they_are_measured_and_a_benchmark_that_raises_stops_no_other(folder):
    environment = {name: value for name, value in os.environ.items() if name != "ROCS_BT_BENCH_QUICK"}
    pipes = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
    process = subprocess.Popen([sys.executable, folder], env=environment, text=True, **pipes)
    first = process.stdout.readline()  # while the benchmark waits for its standard input
    rest, errors = process.communicate("\n")
    assert [" ".join(line.split()) for line in [first, *rest.splitlines()]] == [
        "first 1 s",
        "second 2 s",
        "before 3 s",
        "last 4 s 0.5x another <= 9 s yes",
    ]
    assert process.returncode == 1
    assert "KeyError: 'broken'" in errors
    assert errors.splitlines()[-1] == "1 of 3 benchmarks did not finish: bench_b."


def test_words_choose_and_quick_takes_the_smallest_sizes(folder):
    done = subprocess.run([sys.executable, folder, "--quick", "_c"], capture_output=True, text=True, check=True)
    assert done.stdout.split()[:3] == ["last", "5", "s"]


def test_words_that_match_nothing_are_told_what_there_is(folder):
    done = subprocess.run([sys.executable, folder, "speed"], capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stderr == "no benchmark matches speed. Benchmarks: bench_a, bench_b, bench_c.\n"
