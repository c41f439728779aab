"""Projects of Groot2: `.btproj` files, which include documents and declare nodes."""

import pytest

PROJECT = """<?xml version="1.0" encoding="UTF-8"?>
<root BTCPP_format="4" project_name="P">
  <include path="main.xml"/>
  <include path="trees/sub.xml"/>
  <TreeNodesModel>
    <Action ID="MyAction" editable="true"><input_port name="x" type="int"/></Action>
    <SubTree ID="Sub" editable="true"><input_port name="k" default="3"/></SubTree>
  </TreeNodesModel>
</root>"""


@pytest.fixture
def project(tmp_path):
    (tmp_path / "trees").mkdir()
    (tmp_path / "P.btproj").write_text(PROJECT)
    (tmp_path / "main.xml").write_text(
        '<root BTCPP_format="4"><BehaviorTree ID="Main"><Sequence><MyAction x="1"/><SubTree ID="Sub"/></Sequence>'
        "</BehaviorTree></root>"
    )
    (tmp_path / "trees" / "sub.xml").write_text(
        '<root BTCPP_format="4"><BehaviorTree ID="Sub"><ScriptCondition code="k == 3"/></BehaviorTree></root>'
    )
    return tmp_path


@pytest.mark.parametrize("path", ["P.btproj", "."])
def test_a_project_of_groot2_is_checked_as_a_whole(rocs_bt, project, path):
    found = rocs_bt("check", str(project / path))
    assert found.code == 2
    assert found.out.count("the node 'MyAction' has a model") == len(found.out.splitlines()) - 1 == 1
    assert rocs_bt("check", str(project / path), "--stub-unknown").out == "1 file checked: no faults.\n"
    (project / "main.xml").write_text((project / "main.xml").read_text().replace('x="1"', 'x="1.5"'))
    assert "'1.5' is not a whole number" in rocs_bt("check", str(project / path), "--stub-unknown").out


@pytest.mark.parametrize("arguments", [[], ["--tree", "Main"]])
def test_a_project_of_groot2_is_drawn(rocs_bt, project, arguments):
    drawn = rocs_bt("show", str(project / "P.btproj"), "--stub-unknown", *arguments)
    assert (drawn.code, "MyAction  (stub)" in drawn.out, "k = 3" in drawn.out) == (0, True, True)
    assert "--stub-unknown" in rocs_bt("show", str(project / "P.btproj"), *arguments).err
