"""Requests of the editor: what is opened, checked, edited and saved, and what is refused."""

from __future__ import annotations

import hashlib
import json
import os
import urllib.error
import urllib.request
from concurrent.futures import ThreadPoolExecutor

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.catalog import Catalog
from rocs_bt.cli.main import call
from rocs_bt.studio.authoring import Authoring, edit_routes
from rocs_bt.studio.editing import parse
from rocs_bt.studio.editing.worker import Worker
from rocs_bt.studio.server import Server

from ..waiting import GUARD, until

MISSION = """<root BTCPP_format="4">
  <!-- ä 𝒙 -->
  <BehaviorTree ID="Main">
    <Sequence>
      <GoTo goal="gate"/> <!-- first -->
    </Sequence>
  </BehaviorTree>
</root>
"""
FILE = "planners/missions/mine.xml"


@pytest.fixture
def yard(tmp_path):
    assert call(["new", str(tmp_path / "yard")]) == 0
    (tmp_path / "yard" / FILE).write_text(MISSION, "utf-8")
    return tmp_path / "yard"


@pytest.fixture
def ask(yard):
    table = Authoring(Catalog(yard)).table()
    return lambda request, file=FILE, **body: table[request]({"file": file, **body})


def test_a_text_is_checked_and_drawn_without_being_saved(ask, yard):
    text = MISSION.replace("<GoTo", '<GoTu x="𝒙"')
    found = ask("look", text=text)
    (mark,) = [m for m in found["marks"] if m["level"] == "error"]
    assert mark["instead"] == "GoTo"
    assert (mark["line"], mark["column"], mark["end"]) == (5, 7, 12)
    rows = {row["tag"]: row for row in found["tree"]["rows"]}
    units = text.encode("utf-16-le")
    assert units[2 * rows["GoTu"]["start"] :].decode("utf-16-le").startswith("<GoTu")
    assert rows["GoTu"]["path"] == "0/0/0/0"
    assert (yard / FILE).read_text("utf-8") == MISSION
    assert ask("look", text=MISSION.replace("</Sequence>", ""))["tree"]["whole"] is False


def test_offsets_are_those_of_a_browser(ask):
    at = len(MISSION[: MISSION.index(' goal="gate"')].encode("utf-16-le")) // 2
    node = ask("form", text=MISSION, at=at)
    assert (node["node"], node["path"]) == ("GoTo", "0/0/0/0")
    ports = {port["name"]: port for port in node["ports"]}
    assert ports["goal"]["value"] == "gate"
    assert (ports["cruise"]["value"], ports["cruise"]["default"]) == (None, "0.5 m/s")
    items = ask("complete", text=MISSION.replace('goal="gate"', ""), at=at + 1)["items"]
    assert {item["start"] for item in items} == {at + 1}
    assert "goal" in [item["label"] for item in items]
    assert ask("describe", text=MISSION, at=at - 2)["definition"] is None  # a file of the engine is not opened here


def test_edits_give_the_text_and_the_place_of_the_node(ask):
    edited = ask("edit", text=MISSION, do="insert", parent="0/0/0", new="<Wait/>")
    assert "<!-- first -->\n      <Wait/>\n    </Sequence>" in edited["text"]
    assert edited["path"] == "0/0/0/1"
    edited = ask("edit", text=MISSION, do="set", node="0/0/0/0", name="cruise", value="1 m/s")
    assert 'goal="gate" cruise="1 m/s"/> <!-- first -->' in edited["text"]
    assert ask("edit", text=edited["text"], do="set", node="0/0/0/0", name="cruise", value=None)["text"] == MISSION
    removed = ask("edit", text=MISSION, do="remove", node="0/0/0/0")
    assert "<Sequence/>" in removed["text"]
    assert parse(removed["text"]) is not None
    for wrong in (
        {"do": "set"},
        {"do": "fly"},
        {"do": "move", "node": "x", "parent": "0"},
        {"do": "remove", "node": "9/9"},
    ):
        with pytest.raises(InputError):
            ask("edit", text=MISSION, **wrong)


def test_rule_tests_run_on_the_text(ask, yard):
    text = (yard / "rules" / "keep_clear.toml").read_text("utf-8")
    (passed,) = ask("look", "rules/keep_clear.toml", text=text)["tests"]
    assert passed["passed"]
    (failed,) = ask("look", "rules/keep_clear.toml", text=text.replace("0.25 m, max", "0.2 m, max"))["tests"]
    assert not failed["passed"]
    assert failed["message"]
    assert failed["line"] > 20


def test_save_refuses_what_has_changed_on_disk_and_shows_both(ask, yard):
    opened = ask("open")
    (yard / FILE).write_text(MISSION + "<!-- theirs -->\n", "utf-8")
    reply = ask("save", text=MISSION + "<!-- mine -->\n", hash=opened["hash"])
    assert reply["conflict"]["text"].endswith("<!-- theirs -->\n")
    assert (yard / FILE).read_text("utf-8").endswith("<!-- theirs -->\n")
    reply = ask("save", text=MISSION + "<!-- mine -->\n", hash=reply["conflict"]["hash"])
    assert reply == {"hash": hashlib.sha256((yard / FILE).read_bytes()).hexdigest()}
    assert (yard / FILE).read_text("utf-8").endswith("<!-- mine -->\n")
    (yard / FILE).unlink()
    gone = ask("save", text=MISSION, hash=reply["hash"])["conflict"]
    assert gone["text"] == ""
    assert not (yard / FILE).exists()
    ask("save", text=MISSION, hash=gone["hash"])
    assert (yard / FILE).read_text("utf-8") == MISSION


@pytest.mark.parametrize(
    "raw", [MISSION.replace("\n", "\r\n"), MISSION.replace("\n", "\r\n", 3), "\ufeff" + MISSION, MISSION[:-1]]
)
def test_lines_that_were_not_changed_keep_their_bytes(ask, yard, raw):
    (yard / FILE).write_bytes(raw.encode())
    opened = ask("open")
    assert "\r" not in opened["text"]
    same = ask("save", text=opened["text"], hash=opened["hash"])
    assert (yard / FILE).read_bytes() == raw.encode()
    ask("save", text=opened["text"].replace("gate", "dock"), hash=same["hash"])
    assert (yard / FILE).read_bytes() == raw.replace("gate", "dock").encode()


NOT_OPENED = [
    *("../secret.xml", "/etc/passwd", "README.md", "planners/missions/../../README.md", "planners/missions/out.xml"),
    *("runs/x.toml", "planners/nowhere/none.xml", "", "robots/rover/robot.xml", "../yard2/rules/x.toml"),
]


@pytest.mark.parametrize("file", NOT_OPENED)
def test_only_content_files_of_the_project_are_opened(ask, yard, file):
    (yard.parent / "secret.xml").write_text("secret")
    os.symlink(yard.parent / "secret.xml", yard / "planners" / "missions" / "out.xml")
    for name in ("open", "save", "look"):
        with pytest.raises(InputError):
            ask(name, file, text="x", hash="")


def test_python_and_shipped_files_are_shown_but_not_changed(ask, yard):
    for file in ("planners/missions/patrol.py", "planners/missions/navigate.xml"):
        opened = ask("open", file)
        assert opened["reason"]
        with pytest.raises(InputError):
            ask("save", file, text="x", hash=opened["hash"])
    allowed = Authoring(Catalog(yard), allow_code=True).table()
    opened = allowed["open"]({"file": "planners/missions/patrol.py"})
    assert opened["reason"] == ""
    text = opened["text"] + "# more\n"
    assert "hash" in allowed["save"]({"file": "planners/missions/patrol.py", "text": text, "hash": opened["hash"]})


def test_the_palette_has_the_text_of_new_nodes(ask):
    nodes = {node["name"]: node for node in ask("palette", text=MISSION)["nodes"]}
    assert nodes["GoTo"]["text"] == '<GoTo goal=""/>'
    assert {"Sequence", "RetryUntilSuccessful", "navigate", "Main"} <= nodes.keys()
    assert ask("open", "rules/keep_clear.toml")["scenarios"] == ["first"]


@pytest.mark.parametrize("target", [".git/config", "pyproject.toml", ".git/new.toml"])
def test_a_link_to_a_file_that_is_no_content_is_neither_read_nor_written(ask, yard, target):
    (yard / ".git").mkdir(exist_ok=True)
    if "new" not in target:
        (yard / target).write_text("mine")
    (yard / "rules").mkdir(exist_ok=True)
    (yard / "rules" / "a.toml").symlink_to(yard / target)
    with pytest.raises(InputError, match=r"leads to .* no content file"):
        ask("open", file="rules/a.toml")
    for before in (b"mine", b""):
        with pytest.raises(InputError, match=r"leads to .* no content file"):
            ask("save", file="rules/a.toml", text="x", hash=hashlib.sha256(before).hexdigest())
    assert not (yard / target).exists() if "new" in target else (yard / target).read_text() == "mine"


def test_a_link_to_other_content_of_the_project_is_opened(ask, yard):
    (yard / "planners" / "missions" / "same.xml").symlink_to(yard / FILE)
    assert ask("open", file="planners/missions/same.xml")["text"] == MISSION


def test_a_check_that_takes_long_holds_up_nothing_and_ends_with_an_answer(yard):
    worker = Worker(limit=1.5)
    server = Server("127.0.0.1", 0, "token", edit_routes(Catalog(yard), worker))
    server.start()
    origin = server.url.rsplit("/", 2)[0]

    def post(name, **body):
        fields = {"Origin": origin, "Content-Type": "application/json"}
        request = urllib.request.Request(f"{server.url}edit/{name}", json.dumps(body).encode(), fields)
        try:
            with urllib.request.urlopen(request, timeout=GUARD) as answer:
                return json.loads(answer.read())
        except urllib.error.HTTPError as error:
            return json.loads(error.read())

    rule = '[rule.r%d]\nwhen = "min(front) < %d m"\npriority = %d\n[rule.r%d.action]\ndo = "Stop"\n'
    text = 'format = "reflex/1"\n' + "".join(rule % (k, k, k, k) for k in range(4000))
    try:
        for name in ("form", "look"):  # both processes are ready
            until(lambda name=name: "error" not in post(name, file=FILE, text=MISSION, at=0))
        with ThreadPoolExecutor(60) as pool:
            slow = [pool.submit(post, "look", file="rules/keep_clear.toml", text=text + "#" * k) for k in range(50)]
            assert post("form", file=FILE, text=MISSION, at=0)["node"] is None
            assert not all(each.done() for each in slow)
            answers = [each.result() for each in slow]
        long = [each for each in answers if each is not None]
        assert all("took longer than 1.5 s" in each["error"] for each in long)
        assert 1 <= len(long) <= 2  # the first and the newest; others are not begun
        assert post("look", file=FILE, text=MISSION)["marks"] == []
    finally:
        worker.close()
        server.end()


def test_line_ends_are_kept_in_linear_time(ask, yard):
    lines = [f"<!-- {k % 7} -->" + ("\r\n" if k % 2 else "\n") for k in range(60_000)]
    (yard / FILE).write_bytes("".join(lines).encode())
    opened = ask("open")
    ask("save", text="<a/>\n" + opened["text"] + "<b/>\n", hash=opened["hash"])
    assert sorted((yard / FILE).read_bytes().split(b"\n")) == sorted(
        b"".join([b"<a/>\n", *(line.encode() for line in lines), b"<b/>\n"]).split(b"\n")
    )
