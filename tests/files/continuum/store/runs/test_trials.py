"""Trials in a file: what was kept is found again, and nothing that somebody else, or a damaged disk, has put there."""

from __future__ import annotations

from pathlib import Path

import pytest

from continuum.store.runs.reuse import KeptTrials, read_trials, save_trials

PLACE, FOUND = ("mean-gap", 4096, 1.1, 0.1 + 0.2), [float("nan"), 1 / 3, 7, "CONVERGED"]


def never() -> list[object]:
    raise AssertionError


def test_what_is_kept_is_not_found_anew_and_is_the_same_to_the_bit(tmp_path: Path) -> None:
    path = tmp_path / "run.trials.json"
    first = KeptTrials(path, "one")
    assert first.at(0.01, PLACE, lambda: FOUND) == FOUND
    assert not path.exists()  # a second has not passed
    first.save()
    again = KeptTrials(path, "one")
    assert repr(again.at(0.01, PLACE, never)) == repr(FOUND)
    with pytest.raises(AssertionError):
        again.at(0.02, PLACE, never)
    again.drop()
    assert not path.exists()
    with pytest.raises(AssertionError):
        again.at(0.01, PLACE, never)


def test_each_trial_is_written_where_it_takes_longer_than_that(tmp_path: Path) -> None:
    trials = KeptTrials(tmp_path / "run.trials.json", "one", every=0.0)
    trials.at(0.01, PLACE, lambda: FOUND)
    assert len(read_trials(tmp_path / "run.trials.json", "one")) == 1


@pytest.mark.parametrize("of", ["one", ""])
def test_another_search_and_a_damaged_file_tell_nothing(of: str, tmp_path: Path) -> None:
    path = tmp_path / "run.trials.json"
    save_trials(path, [(0.5, "a"), (0.25, "b")], of)
    assert read_trials(path, of) == [(0.5, "a"), (0.25, "b")]
    assert read_trials(path, "two") == []
    text = path.read_text()
    for wrong in (text[:-5], text.replace("[[", "["), "[]", ""):
        path.write_text(wrong)
        assert read_trials(path, of) == []
    path.write_text(text.replace("0.25", "0.26"))
    assert read_trials(path, "one") == []
