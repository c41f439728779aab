"""The tests that stand in rule files, as pytest's own: what the plugin collects."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from ..reactive import RuleTestResult


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> RuleFileTests | None:
    """A rule file of a project as a file of tests."""
    if file_path.suffix != ".toml" or file_path.parent.name != "rules":
        return None
    collected: RuleFileTests = RuleFileTests.from_parent(parent, path=file_path)
    return collected


class RuleFileTests(pytest.File):
    """The tests of one rule file, for each robot that flinches by it."""

    def collect(self) -> Iterator[RuleFileTest]:
        """Run them all, which takes no longer than to find them; a file that is wrong is an error of collection."""
        from ..catalog import Catalog, make_entry
        from ..check import fitted_rules
        from ..errors import InputError
        from ..reactive import run_tests

        try:
            fitted = fitted_rules(make_entry(self.path, "rules", "file"), Catalog.here(self.path.parent))
        except InputError as error:
            raise self.CollectError(str(error)) from error
        for robot, rules in fitted:
            for result in run_tests(rules):
                name = f"{result.rule.rpartition('/')[2]}: {result.test} [{robot}]"
                yield RuleFileTest.from_parent(self, name=name, result=result)


class RuleFileTest(pytest.Item):
    """One test that stands in a rule file."""

    def __init__(self, *, result: RuleTestResult, **of: Any) -> None:
        super().__init__(**of)
        self.result = result

    def runtest(self) -> None:
        """Fail where it did."""
        if not self.result.passed:
            place = self.result.place
            pytest.fail(f"{place.file}:{place.line}:{place.column}: {self.result.message}", pytrace=False)

    def reportinfo(self) -> tuple[Path, int, str]:
        """Where it stands."""
        return self.path, max(self.result.place.line - 1, 0), self.name
