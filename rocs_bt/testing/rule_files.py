"""Pytest items for the tests in rule files."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from ..base.files import is_file

if TYPE_CHECKING:
    from ..reactive import RuleTestResult


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> RuleFileTests | None:
    """Return a collector for a project's rule file or a file in its `rules/tests`; None for any other file."""
    from ..reactive import tested_file

    if file_path.suffix != ".toml" or tested_file(file_path).parent.name != "rules":
        return None
    collected: RuleFileTests = RuleFileTests.from_parent(parent, path=file_path)
    return collected


class RuleFileTests(pytest.File):
    """Collector of the tests in one file; each test runs once for each robot that uses the rules."""

    def collect(self) -> Iterator[RuleFileTest]:
        """Run all tests now, which takes no longer than collecting them; an invalid file is a collection error."""
        from ..base.errors import InputError
        from ..catalog import Catalog, make_entry
        from ..check import fitted_rules
        from ..reactive import run_tests, tested_file

        rule_file = tested_file(self.path)
        if not is_file(rule_file):
            raise self.CollectError(f"{self.path}: the rule file {rule_file} does not exist.")
        apart = rule_file.parent / "tests"
        try:
            fitted = fitted_rules(make_entry(rule_file, "rules", "file"), Catalog.here(rule_file.parent))
        except InputError as error:
            raise self.CollectError(str(error)) from error
        for robot, rules in fitted:
            for result in run_tests(rules):
                if (result.position.file.parent == apart) != (self.path.parent == apart):
                    continue
                name = f"{result.rule.rpartition('/')[2]}: {result.test} [{robot}]"
                yield RuleFileTest.from_parent(self, name=name, result=result)


class RuleFileTest(pytest.Item):
    """One test of a rule file for one robot, with its result."""

    def __init__(self, *, result: RuleTestResult, **of: Any) -> None:
        super().__init__(**of)
        self.result = result

    def runtest(self) -> None:
        """Fail if the rule test failed."""
        if not self.result.passed:
            position = self.result.position
            pytest.fail(f"{position.file}:{position.line}:{position.column}: {self.result.message}", pytrace=False)

    def reportinfo(self) -> tuple[Path, int, str]:
        """File, line and name of the test."""
        return self.path, max(self.result.position.line - 1, 0), self.name
