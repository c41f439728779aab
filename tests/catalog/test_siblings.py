"""Files of content that import siblings: one module for each file, faults at the sibling's line, one hash for all."""

from __future__ import annotations

import pickle
import sys
import threading

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.base.python_content import load_class, load_module, module_name, with_siblings
from rocs_bt.base.raised import CONTENT_PREFIX, raised_at
from rocs_bt.catalog import Catalog

OWN = "from .far import Far\n\n\nclass Own(Far):\n    pass\n"
FAR = "from .limit import LIMIT\n\n\nclass Far:\n    limit = LIMIT\n\n    def fail(self):\n        return 1 / 0\n"


@pytest.fixture
def folder(tmp_path):
    """A folder of content: own.py imports far.py, which imports limit.py."""
    folder = tmp_path / "bot.v2"
    folder.mkdir()
    for name, text in (("own", OWN), ("far", FAR), ("limit", "LIMIT = 3\n")):
        (folder / f"{name}.py").write_text(text)
    return folder


def append(file, text):
    file.write_text(file.read_text() + text)


def modules_of(folder):
    package = module_name(folder / "own.py").partition(".")[0]
    return {name.rpartition(".")[2] for name in sys.modules if name.startswith(f"{package}.")}


def fault_of(path):
    with pytest.raises(InputError) as caught:
        load_module(path)
    (fault,) = caught.value.faults
    return fault


def test_a_file_imports_its_siblings_and_each_has_one_module(folder):
    own = load_class(folder / "own.py", "Own")
    far = load_class(folder / "far.py", "Far")
    assert own.__mro__[1] is far
    assert own.limit == 3
    assert own.__module__.startswith(CONTENT_PREFIX)
    assert modules_of(folder) == {"own", "far", "limit"}
    assert type(pickle.loads(pickle.dumps(own()))) is own
    assert type(pickle.loads(pickle.dumps(far()))) is far


def test_files_of_one_name_in_two_folders_have_two_modules(folder):
    other = folder.with_name("bot")
    other.mkdir()
    (other / "limit.py").write_text("LIMIT = 4\n")
    assert (load_module(folder / "limit.py").LIMIT, load_module(other / "limit.py").LIMIT) == (3, 4)


def test_a_file_and_a_link_to_it_are_one_module(folder):
    link = folder.with_name("linked.py")
    link.symlink_to(folder / "own.py")
    assert load_module(link) is load_module(folder / "own.py")


def test_a_file_name_may_have_dots(folder):
    (folder / "own.v2.py").write_text(OWN)
    own = load_class(folder / "own.v2.py", "Own")
    assert own is not load_class(folder / "own.py", "Own")
    assert type(pickle.loads(pickle.dumps(own()))) is own


def test_siblings_can_be_imported_late_and_from_the_folder(folder):
    (folder / "own.py").write_text(
        "def late():\n    from . import far\n    from .limit import LIMIT\n    return far, LIMIT\n"
    )
    assert load_module(folder / "own.py").late() == (load_module(folder / "far.py"), 3)


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        ("x = 1\ny = 1 / 0\n", "limit.py:2", "ZeroDivisionError"),
        ("x = 1\ny = 1 +\n", "limit.py:2:8", "not valid Python"),
        ("import rocs_bt.base.units\n\nrocs_bt.base.units.parse_quantity('1 bogus')\n", "limit.py:3", "bogus"),
        ("x = 1\n", "far.py:1", "ImportError: cannot import name 'LIMIT'"),
        ("from .own import Own\n", "limit.py:1", "ImportError: cannot import name 'Own'"),
        ("LIMIT = 3\nraise SystemExit(1)\n", "limit.py:2", "SystemExit"),
    ],
)
def test_what_a_sibling_raises_is_reported_at_its_line_and_leaves_no_module(folder, text, place, message):
    (folder / "limit.py").write_text(text)
    fault = fault_of(folder / "own.py")
    assert f"{folder / place}: " in str(fault)
    assert message in fault.message
    assert modules_of(folder) == set()


def test_siblings_of_a_file_that_raises_are_loaded_again_with_it(folder):
    (folder / "own.py").write_text(OWN + "1 / 0\n")
    kept = load_module(folder / "limit.py")
    assert fault_of(folder / "own.py").line == 6
    assert modules_of(folder) == {"limit"}
    (folder / "own.py").write_text("from . import far\nfrom .far import Far\n")
    (folder / "far.py").write_text("class Far:\n    changed = True\n")
    assert load_module(folder / "own.py").far.Far.changed
    assert load_module(folder / "limit.py") is kept


def test_what_a_sibling_raises_later_is_at_its_line(folder):
    own = load_class(folder / "own.py", "Own")
    with pytest.raises(ZeroDivisionError) as caught:
        own().fail()
    assert str(raised_at(caught.value)) == "far.py:8"


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (
            "from .fra import Far",
            "no file is named 'fra.py'. Did you mean 'far.py'? The folder has: far.py, limit.py, own.py.",
        ),
        ("from . import fra", "no file is named 'fra.py'. Did you mean 'far.py'?"),
        ("from ..secret import X", "ImportError: attempted relative import beyond top-level package"),
        ("from .. import secret", "ImportError: attempted relative import beyond top-level package"),
        ("from .parts import X", "no file is named 'parts.py'"),
        ("from .parts.arm import X", "no file is named 'parts.py'"),
        ("from .far.arm import X", "is not a package"),
        ("from .built import X", "no file is named 'built.py'"),
        ("from .linked import X", "'linked.py' is a link. Put the file itself into the folder."),
        ("import far", "No module named 'far'"),
    ],
)
def test_nothing_but_a_sibling_can_be_imported(folder, line, message):
    (folder / "parts").mkdir()
    for file in ("parts/__init__.py", "parts/arm.py", "../secret.py", "built.pyc", "built/__init__.py"):
        (folder / file).parent.mkdir(exist_ok=True)
        (folder / file).write_text("X = 1\n")
    (folder / "linked.py").symlink_to(folder.parent / "secret.py")
    (folder / "own.py").write_text(f"X = 1\n{line}\n")
    fault = fault_of(folder / "own.py")
    assert (fault.file, fault.line) == (folder / "own.py", 2)
    assert message in fault.message


def test_threads_get_one_module_that_is_complete(folder):
    (folder / "limit.py").write_text("import time\n\ntime.sleep(0.2)\nLIMIT = 3\n")
    found = []

    def load(name):
        found.append(vars(load_module(folder / f"{name}.py")))

    loaders = [threading.Thread(target=load, args=(name,)) for name in ("own", "far", "limit", "own")]
    for loader in loaders:
        loader.start()
    for loader in loaders:
        loader.join()
    assert all({"Own", "Far", "LIMIT"} & names.keys() for names in found)
    assert len(found) == 4
    assert load_class(folder / "own.py", "Own").__mro__[1] is load_class(folder / "far.py", "Far")


def test_files_that_are_imported_are_found_without_running_them(folder):
    for name in ("own", "far", "limit"):
        append(folder / f"{name}.py", "\nraise SystemExit\n")
    append(folder / "far.py", "from . import own, limit, nothing\nfrom ..x import limit\nimport json\n")
    assert sorted(file.name for file in with_siblings(folder / "own.py")) == ["far.py", "limit.py", "own.py"]
    assert modules_of(folder) == set()


@pytest.mark.parametrize("file", ["planners/missions/_places.py", "planners/missions/_far.py", "robots/bot/far.py"])
def test_the_hash_covers_siblings(project, file):
    missions, robot = project / "planners" / "missions", project / "robots" / "bot"
    (missions / "go.py").write_text("from ._places import PLACE\n\n\ndef build(mission):\n    return PLACE\n")
    (missions / "_places.py").write_text("from ._far import PLACE as PLACE\n")
    (missions / "_far.py").write_text("PLACE = 1\n")
    (robot / "far.py").write_text("FAR = 1\n")
    before = Catalog(project).digest(Catalog(project).load_scenario("walk"))
    append(project / file, "\n")
    assert Catalog(project).digest(Catalog(project).load_scenario("walk")) != before
    assert [entry.name for entry in Catalog(project).list("mission") if entry.origin == "project"] == ["go"]


def test_what_a_mission_names_in_a_sibling_belongs_to_it(project):
    missions, nodes = project / "planners" / "missions", project / "planners" / "nodes"
    nodes.mkdir()
    (nodes / "wave.py").write_text("class Wave:\n    pass\n")
    (missions / "go.py").write_text("from ._tree import TREE\n")
    (missions / "_tree.py").write_text("TREE = 'Wave'\n")
    catalog = Catalog(project)
    assert [entry.name for entry in catalog.python_of(catalog.find("mission", "go"))] == ["wave"]
