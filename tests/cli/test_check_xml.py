"""`rocs-bt check` of XML files from elsewhere: what they are, whose nodes they name, where their subtrees are."""

# ruff: noqa: E501 - a document stands in one line

import pytest

MAIN = """<root BTCPP_format="4">
  <BehaviorTree ID="Play"><Sequence>
    <SubTree ID="Attack" ball="{ball}"/>
    <SequenceStar><FindBall out="{ball}"/><KickBall power="0.5"/></SequenceStar>
    <FindBall out="{b2}"/>
  </Sequence></BehaviorTree>
  <TreeNodesModel>
    <Action ID="KickBall"><input_port name="power" type="double"/></Action>
  </TreeNodesModel>
</root>"""
ATTACK = """<root BTCPP_format="4"><BehaviorTree ID="Attack">
  <Sequence><KickBall power="{ball}"/><SubTree ID="Deep"/></Sequence>
</BehaviorTree></root>"""
DEEP = '<root BTCPP_format="4"><BehaviorTree ID="Deep"><AlwaysSuccess/></BehaviorTree></root>'
PALETTE = """<root BTCPP_format="4"><TreeNodesModel>
  <Condition ID="FindBall"><bidirectional_port name="out" type="geometry_msgs::msg::Point">where</bidirectional_port></Condition>
</TreeNodesModel></root>"""


@pytest.fixture
def folder(tmp_path):
    for name, text in {"main": MAIN, "attack": ATTACK, "deep": DEEP, "palette": PALETTE}.items():
        (tmp_path / f"{name}.xml").write_text(text)
    return tmp_path


def check(rocs_bt, folder, *arguments):
    found = rocs_bt("check", *(str(folder / a) if a.endswith(".xml") or a == "." else a for a in arguments))
    *lines, summary = (found.out or found.err).splitlines()
    return found.code, [line.removeprefix(f"{folder}/") for line in lines], summary


@pytest.mark.parametrize(
    ("name", "text", "code", "says"),
    [
        ("tree", DEEP, 0, ""),
        ("tree", DEEP.replace("AlwaysSuccess", "AlwaysSucess"), 2, "Did you mean 'AlwaysSuccess'"),
        ("tree", "<?xml version='1.0'?>\n<!-- <mujoco> -->\n" + DEEP, 0, ""),
        ("tree", "// by hand\n" + DEEP, 0, "1:1: warning: there is text before the root element."),
        ("palette", PALETTE, 0, ""),
        ("model", "<mujoco><worldbody/></mujoco>", 0, ""),
        ("empty", "", 2, "the file contains no XML element."),
    ],
)
def test_a_file_is_checked_as_what_it_holds(rocs_bt, tmp_path, name, text, code, says):
    (tmp_path / f"{name}.xml").write_text(text)
    found = check(rocs_bt, tmp_path, f"{name}.xml")
    assert found[0] == code, found
    assert says in "\n".join(found[1])
    if code and name not in ("tree", "model"):
        assert "Behaviour trees (<root BTCPP_format=...>) and MJCF models (<mujoco>) can be checked." in found[1][0]


def test_what_is_missing_is_an_error_without_options(rocs_bt, folder):
    code, lines, summary = check(rocs_bt, folder, "main.xml")
    assert (code, summary) == (2, "1 file checked: 4 errors, 0 warnings.")
    assert "no tree is named 'Attack'" in lines[0]
    assert lines[0].endswith("Check it together with the file that holds the tree, or with --stub-unknown.")
    (unknown,) = [line for line in lines if "no node is named 'FindBall'" in line][:1]
    assert unknown.endswith("For nodes of another robot use --palette FILE or --stub-unknown.")
    assert "the node 'KickBall' has a model in the TreeNodesModel but no class." in "\n".join(lines)


def test_subtrees_of_files_that_are_checked_together_are_found(rocs_bt, folder):
    lines = check(rocs_bt, folder, "main.xml", "attack.xml", "deep.xml")[1]
    assert not [line for line in lines if "no tree is named" in line]


def test_stubs_take_the_place_of_what_is_unknown_with_one_warning_each(rocs_bt, folder):
    code, lines, summary = check(rocs_bt, folder, "--stub-unknown", "main.xml", "attack.xml")
    assert (code, summary) == (0, "2 files checked: 0 errors, 2 warnings.")
    assert lines[1].startswith("main.xml:4:19: warning: no node is named 'FindBall'; a stub replaces it (2 uses).")
    assert [line for line in lines if "no tree is named 'Deep' in the checked files" in line]


def test_a_name_is_told_once_for_all_files(rocs_bt, tmp_path):
    for i in range(5):
        (tmp_path / f"f{i}.xml").write_text(DEEP.replace('"Deep"', f'"T{i}"').replace("AlwaysSuccess", "Strange"))
    code, lines, summary = check(rocs_bt, tmp_path, "--stub-unknown", ".")
    assert (code, summary) == (0, "5 files checked: 0 errors, 1 warning.")
    assert lines[0].startswith(
        "f0.xml:1:46: warning: no node is named 'Strange'; a stub replaces it (5 uses in 5 files)."
    )


def test_what_an_included_file_lacks_is_told_there(rocs_bt, tmp_path):
    (tmp_path / "parts").mkdir()
    part = '<Sequence><Strange/><SubTree ID="Gone"/></Sequence>'
    (tmp_path / "parts/deep.xml").write_text(DEEP.replace("<AlwaysSuccess/>", part))
    (tmp_path / "main.xml").write_text(
        '<root BTCPP_format="4"><include path="parts/deep.xml"/><BehaviorTree ID="M"><SubTree ID="Deep"/></BehaviorTree></root>'
    )
    code, lines, _ = check(rocs_bt, tmp_path, "--stub-unknown", "main.xml")
    assert code == 0
    assert [line.split(":")[0] for line in lines] == ["parts/deep.xml"] * 2


def test_a_folder_and_a_palette_leave_no_doubt(rocs_bt, folder):
    code, lines, summary = check(rocs_bt, folder, "--palette", "palette.xml", ".")
    assert (code, lines, summary) == (0, [], "4 files checked: no faults.")


@pytest.mark.parametrize(
    ("before", "after", "says"),
    [
        ('power="0.5"', 'power="strong"', "'strong' is not a number"),
        ('power="0.5"', 'pwer="0.5"', "no port is named 'pwer'. Did you mean 'power'?"),
        ('<KickBall power="0.5"/>', '<KickBall power="0.5"><AlwaysSuccess/></KickBall>', "needs no children, found 1"),
    ],
)
def test_declared_nodes_are_checked_as_the_palette_says(rocs_bt, folder, before, after, says):
    (folder / "main.xml").write_text(MAIN.replace(before, after))
    code, lines, _ = check(rocs_bt, folder, "--palette", "palette.xml", ".")
    assert code == 2
    assert [line for line in lines if says in line], lines


def test_a_palette_that_declares_nothing_is_refused(rocs_bt, folder):
    code, _, error = check(rocs_bt, folder, "--palette", "deep.xml", "main.xml")
    assert (code, "the palette declares no node" in error) == (2, True)


@pytest.mark.parametrize(
    "kind",
    [
        "geometry_msgs::msg::PoseStamped",
        "std::vector&lt;double&gt;",
        "nav_msgs::msg::Path const&amp;",
        "Pose2D",
        "uint16",
        "std::uint8_t",
        "const std::string&amp;",
        "BT::NodeStatus",
        "std::shared_ptr&lt;Foo&gt;",
    ],
)
def test_types_of_cpp_are_types_of_ports(rocs_bt, tmp_path, kind):
    model = f'<TreeNodesModel><SubTree ID="Deep"><input_port name="p" type="{kind}" default="1"/></SubTree></TreeNodesModel>'
    (tmp_path / "tree.xml").write_text(DEEP.replace("</root>", f"{model}</root>"))
    assert check(rocs_bt, tmp_path, "tree.xml") == (0, [], "1 file checked: no faults.")


def test_a_file_of_several_trees_without_a_main_one_is_checked_tree_by_tree(rocs_bt, tmp_path):
    trees = "".join(f'<BehaviorTree ID="{n}"><Script code="{n} := y_{n}"/></BehaviorTree>' for n in "AB")
    (tmp_path / "tree.xml").write_text(f'<root BTCPP_format="4">{trees}</root>')
    code, lines, _ = check(rocs_bt, tmp_path, "tree.xml")
    assert code == 0
    assert [line for name in "AB" for line in lines if f"'y_{name}'" in line], lines
    assert not [line for line in lines if "nothing uses" in line]


REQUIRED = """<root BTCPP_format="4" main_tree_to_execute="Main"><BehaviorTree ID="Main"><Sequence>
  <RetryUntilSuccessful num_attempts="two"><AlwaysSuccess/></RetryUntilSuccessful>
  <GoTo goal="{goal}"/><Sleep msec="{pause}"/><GooTo goal="x"/></Sequence></BehaviorTree>
<TreeNodesModel><SubTree ID="Main"><input_port name="goal"/><input_port name="pause"/></SubTree></TreeNodesModel></root>
"""


@pytest.mark.parametrize("unknown", [False, True])
def test_a_mission_that_requires_parameters_is_checked_without_them(tmp_path, rocs_bt, unknown):
    file = tmp_path / "planners" / "missions" / "needs.xml"
    file.parent.mkdir(parents=True)
    file.write_text(REQUIRED if unknown else REQUIRED.replace('<GooTo goal="x"/>', ""))
    told = rocs_bt("check", file)
    assert told.code == 2
    literal = [line for line in told.out.splitlines() if "needs.xml:2:25: 'RetryUntilSuccessful'" in line]
    assert unknown or "'two' is not a whole number" in literal[0]
    if unknown:
        (line,) = (line for line in told.out.splitlines() if "no node is named 'GooTo'" in line)
        assert "Did you mean 'GoTo'?" in line
        assert line.count(",") < 8  # the nearest names, not all
    assert f"{1 + unknown} error" in told.out
