"""`rocs-bt compare --report --markdown`, and `rocs-bt run --planner`."""

import re
import shlex


def test_a_comparison_writes_its_page_and_its_tables(project, rocs_bt):
    command = "compare brisk careful --scenario first --seeds 2 --jobs 1 --report out/page.html --markdown page.md"
    told = rocs_bt(*shlex.split(command))
    assert told.code == 0, told.err
    assert told.out.rstrip().endswith("Report: out/page.html")
    page, tables = (project / "out" / "page.html").read_text(), (project / "page.md").read_text()
    assert f"<pre>rocs-bt {command}</pre>" in page
    assert "Inconclusive: brisk against careful." in page
    assert "| brisk | 100.0 %" in tables
    again = rocs_bt("run", "first", "--planner", "brisk", "--seed", "2")
    assert again.code == 0
    assert re.search(r"Report: runs/brisk-first-2/report.html", again.out)
