"""`check --no-code`: each mission in XML is judged, or a note says why not."""

import pytest

from rocs_bt.catalog import Catalog
from rocs_bt.check import check_content

from ..cli import nav2_mission

SHIPPED = {entry.name: entry.path.read_text() for entry in Catalog().list("mission") if entry.path.suffix == ".xml"}


@pytest.mark.parametrize("name", [*SHIPPED, "nav2"])
def test_a_mission_is_judged_or_a_note_says_what_it_would_run(tmp_path, name):
    (tmp_path / "planners" / "missions").mkdir(parents=True)
    file = tmp_path / "planners" / "missions" / f"{name}_copy.xml"
    text = nav2_mission.mission() if name == "nav2" else SHIPPED[name]
    begin = text.index(">", text.index("<BehaviorTree ")) + 1
    file.write_text(
        f"{text[:begin]}<Sequence><Nonsense/>{text[begin:].replace('</BehaviorTree>', '</Sequence></BehaviorTree>', 1)}"
    )
    messages = [str(fault) for fault in check_content([file], code=False).faults]
    assert any("Nonsense" in each or ("not judged" in each and "--no-code" in each) for each in messages)
