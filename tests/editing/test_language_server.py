"""The language server, spoken to by a scripted client over its standard input and output."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from rocs_bt.cli.main import call

from .. import needs
from ..noise import write_noisy_project
from .conftest import MISSION
from .test_worker import NODE


class Client:
    """Client of the Language Server Protocol that sends requests and reads until their answers."""

    def __init__(self, folder: Path) -> None:
        command = [sys.executable, "-m", "rocs_bt", "language-server"]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=folder)
        self.versions: dict[str, int] = {}
        self.folder, self.count, self.diagnostics = folder, 0, dict[str, dict[str, Any]]()

    def start(self) -> None:
        self.ask("initialize", processId=None, rootUri=self.folder.as_uri(), capabilities={})
        self.tell("initialized")

    def end(self) -> None:
        self.process.stdin.close()
        self.process.stdout.close()
        self.process.kill()
        self.process.wait(30)

    def send(self, message: dict[str, Any]) -> None:
        body = json.dumps({"jsonrpc": "2.0", **message}).encode()
        self.process.stdin.write(b"Content-Length: %d\r\n\r\n%b" % (len(body), body))
        self.process.stdin.flush()

    def tell(self, method: str, **params: Any) -> None:
        self.send({"method": method, "params": params})

    def ask(self, method: str, **params: Any) -> Any:
        self.count += 1
        self.send({"id": self.count, "method": method, "params": params})
        while (message := self.read()).get("id") != self.count or "method" in message:
            pass
        assert "error" not in message, message
        return message["result"]

    def read(self) -> dict[str, Any]:
        length = 0
        while line := self.process.stdout.readline().strip():
            if line.lower().startswith(b"content-length:"):
                length = int(line.split(b":")[1])
        message: dict[str, Any] = json.loads(self.process.stdout.read(length))
        if message.get("method") == "textDocument/publishDiagnostics":
            self.diagnostics[message["params"]["uri"]] = message["params"]
        return message

    def open(self, file: Path, text: str) -> None:
        item = {"uri": file.as_uri(), "languageId": "xml", "version": 1, "text": text}
        self.versions[item["uri"]] = 1
        self.tell("textDocument/didOpen", textDocument=item)

    def type(self, file: Path, text: str) -> None:
        self.versions[file.as_uri()] += 1
        document = {"uri": file.as_uri(), "version": self.versions[file.as_uri()]}
        self.tell("textDocument/didChange", textDocument=document, contentChanges=[{"text": text}])

    def at(self, method: str, file: Path, line: int, character: int) -> Any:
        position = {"line": line, "character": character}
        return self.ask(f"textDocument/{method}", textDocument={"uri": file.as_uri()}, position=position)

    def faults(self, file: Path) -> list[dict[str, Any]]:
        """Diagnostics of the newest text of a file."""
        uri = file.as_uri()
        while self.diagnostics.get(uri, {}).get("version") != self.versions[uri]:
            self.read()
        return self.diagnostics.pop(uri)["diagnostics"]


@pytest.fixture
def client(yard):
    needs.package("pygls")
    client = Client(yard)
    try:
        client.start()
        yield client
        client.ask("shutdown")
        client.tell("exit")
        assert client.process.wait(30) == 0
    finally:
        client.end()


def test_an_editor_gets_faults_as_typed_completion_descriptions_and_definitions(client, yard):
    mission = yard / "planners" / "missions" / "new ä.xml"
    wrong = MISSION % '<!-- 𝒙 --> <RetryUntilSuccessful num_attempts="two"><GoTo goal="gate"/></RetryUntilSuccessful>'
    client.open(mission, wrong)
    (fault,) = [f for f in client.faults(mission) if f["severity"] == 1]
    line = wrong.split("\n")[4]
    begin = len(line[: line.index("num_attempts")].encode("utf-16-le")) // 2
    assert fault["range"]["start"]["line"] == 4
    assert fault["range"]["start"]["character"] >= begin
    assert "not a whole number" in fault["message"]

    client.type(mission, wrong.replace("two", "2").replace("<GoTo goal", "<GoTu goal"))
    fault = next(f for f in client.faults(mission) if "no node is named 'GoTu'" in f["message"])
    assert "Did you mean 'GoTo'?" in fault["message"]
    assert "PipelineSequence" not in fault["message"]
    (action,) = client.ask(
        "textDocument/codeAction",
        textDocument={"uri": mission.as_uri()},
        range=fault["range"],
        context={"diagnostics": [fault]},
    )
    ((edit,),) = action["edit"]["changes"].values()
    assert edit["newText"] == "GoTo"
    fixed = wrong.replace("two", "2")
    client.type(mission, fixed)
    assert [f for f in client.faults(mission) if f["severity"] == 1] == []

    client.type(mission, MISSION % "<")
    found = {item["label"]: item for item in client.at("completion", mission, 4, 7)}
    assert {"Sequence", "GoTo", "SubTree Leg"} <= found.keys()
    assert found["GoTo"]["textEdit"]["newText"] == 'GoTo goal=""/>'
    client.type(mission, fixed)
    at = fixed.split("\n")[4].index("<RetryUntil") + 5
    assert "num_attempts" in client.at("hover", mission, 4, at)["contents"]["value"]
    assert client.at("definition", mission, 5, 25)["range"]["start"]["line"] == 8
    assert not mission.exists()


@pytest.mark.parametrize(
    ("file", "old", "new", "message", "complete"),
    [
        ("scenarios/first.toml", 'mission = "patrol"', 'mission = "patrul"', "no mission is named", "patrol"),
        ("rules/keep_clear.toml", "min(front) <", "min(frond) <", "no signal or alias is named", None),
        ("robots/rover/robot.toml", 'kind = "skid"', 'kind = "skit"', "invalid value 'skit'", "skid"),
    ],
)
def test_all_four_kinds_of_files_are_served(client, yard, file, old, new, message, complete):
    text = (yard / file).read_text("utf-8")
    assert old in text
    client.open(yard / file, text)
    assert [f for f in client.faults(yard / file) if f["severity"] == 1] == []
    client.type(yard / file, text.replace(old, new, 1))
    found = [f for f in client.faults(yard / file) if message in f["message"]]
    line = text[: text.index(old)].count("\n")
    assert found[0]["range"]["start"]["line"] == line
    if complete:
        labels = [i["label"] for i in client.at("completion", yard / file, line, len(new) - 1)]
        assert complete in labels
    client.tell("textDocument/didClose", textDocument={"uri": (yard / file).as_uri()})


def test_content_that_prints_does_not_reach_the_editor(tmp_path):
    needs.package("pygls")
    folder = write_noisy_project(tmp_path / "loud")
    client = Client(folder)
    try:
        client.start()
        scenario = folder / "scenarios" / "loud.toml"
        client.open(scenario, scenario.read_text())
        assert [f for f in client.faults(scenario) if f["severity"] == 1] == []
        client.open(folder / "planners" / "missions" / "new.xml", MISSION % "<Shout/>")
        assert client.at("completion", folder / "planners" / "missions" / "new.xml", 4, 7)
    finally:
        client.end()


def test_a_python_file_that_was_saved_counts_at_once_and_a_slow_check_holds_up_nothing(client, yard):
    mission, node = yard / "planners" / "missions" / "mine.xml", yard / "planners" / "nodes" / "shine.py"
    node.parent.mkdir()
    node.write_text(NODE)
    text = MISSION % '<Shine colour="red"/>'
    client.open(mission, text)
    assert [f for f in client.faults(mission) if f["severity"] == 1] == []
    node.write_text(NODE.replace("    colour:", "    shades:"))
    client.type(mission, text + " ")
    assert any("colour" in f["message"] for f in client.faults(mission))
    node.write_text("import time\ntime.sleep(600)\n")
    client.type(mission, text)
    rules = yard / "rules" / "keep_clear.toml"
    assert client.at("hover", rules, 4, 1)  # answered while the check goes on
    shutil.rmtree(node.parent)  # the server ends although the check goes on


def test_without_pygls_the_command_says_what_to_install(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "pygls.lsp.server", None)
    monkeypatch.setitem(sys.modules, "lsprotocol", None)
    assert call(["language-server"]) == 2
    assert "pip install 'rocs_bt[editor]'" in capsys.readouterr().err
