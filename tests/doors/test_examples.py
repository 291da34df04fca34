"""The examples in the docstrings of public names are run, and what people call first has one."""

from __future__ import annotations

import doctest
import inspect
from pathlib import Path
from types import ModuleType

import pytest

import atomistic
import continuum

# Errors, what functions return, and functions without an argument that matters.
WITHOUT = {
    continuum: {
        "Analysis", "Certificate", "ConfigError", "FoundThreshold", "NotConvergedError", "NotConvergedWarning",
        "Prediction", "StoreError", "Study", "SweepTask", "analyse", "doctor", "examples", "figure", "study",
        "sweep_slurm",
    },
    atomistic: {
        "Deck", "DeckCertificate", "DeckRun", "Elastic", "LammpsError", "PairStyle", "PotentialError", "Round",
        "SlabResponse", "Trace", "Validation", "WallInclude", "Waves", "check", "doctor", "read_trace", "validate",
    },
}  # fmt: skip


def examples_of(package: ModuleType) -> dict[str, list[doctest.DocTest]]:
    """The examples of each public name, and those of its methods."""
    finder = doctest.DocTestFinder()
    found = {}
    for name in package.__all__:
        public = getattr(package, name)
        tests = finder.find(public, name, module=inspect.getmodule(public), globs={})
        found[name] = [test for test in tests if test.examples]
    return found


@pytest.mark.parametrize("package", [continuum, atomistic], ids=lambda package: package.__name__)
def test_the_examples_of_public_names_print_what_they_say(
    package: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    tests = examples_of(package)
    assert {name for name, own in tests.items() if not any(test.name == name for test in own)} == WITHOUT[package]
    # `c.sweep_status` and its like look at the sweep of the example of `c.sweep`.
    in_turn = sorted(tests, key=lambda name: (name.startswith("sweep_"), name))
    failures = list[str]()
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)  # tables end lines with blanks
    for name in in_turn:
        for test in tests[name]:
            runner.run(test, out=failures.append)
    assert not failures, "".join(failures)
