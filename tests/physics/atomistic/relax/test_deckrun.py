"""The continuum that is put beside a run of a deck."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

import atomistic as a
import continuum as c
from atomistic.front.cli import main
from atomistic.lammps.result import DeckError
from atomistic.relax.deckrun import DeckSteps
from atomistic.show.decks import WRITERS
from continuum.store.output import save


def test_beside_a_deck_stands_the_response_of_its_own_slab(tmp_path: Path) -> None:
    grid = c.Grid.square(12)
    heights = c.SelfAffine(0.8, 0.02, 4, 12).synthesise(grid, np.random.default_rng(1))
    contact = c.Contact(heights, c.LennardJonesSpline(adhesion_length=0.005))
    own = a.deck(contact, separations=[1.2, 1.1], depth=12).write(tmp_path / "own")
    run = a.run_deck(own)
    without = shutil.copytree(own, tmp_path / "without")
    (without / "stiffness.npy").unlink()
    isotropic = a.read(without)
    differences = []
    for each in (run, isotropic):
        pairs = zip(each.steps, each.compare(), strict=True)
        differences.append([(one.load - step.load) / (step.load_rep + step.load_att) for step, one in pairs])
    # The atoms differ from their own linear response by strains of 2 %, from a half-space by the lattice at 4 a0.
    assert np.abs(differences[0]).max() < 0.01
    assert np.abs(differences[1]).min() > 2 * np.abs(differences[0]).max()
    told = run.sheets(compare=True)[-1].text(), isotropic.sheets(compare=True)[-1].text()
    assert "the slab's own linear response" in told[0]
    assert "an isotropic half-space" in told[1]
    assert "at rest, at 0 K" in told[0]
    (without / "stiffness.npy").write_bytes(b"\x93NUMPY")
    with pytest.raises(DeckError, match="damaged"):
        a.read(without)


def test_a_deck_of_equilibria_has_no_windows_and_is_written_in_every_form_there_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    contact = c.Contact(c.sine(c.Grid.square(4), 0.01, (1, 0)), c.LennardJonesSpline(adhesion_length=0.005))
    run = a.run_deck(a.deck(contact, separation=1.2, depth=3).write(tmp_path / "deck"))
    assert run.averaged == ()
    with pytest.raises(DeckError, match="dwell"):
        run.mean("load")
    with pytest.raises(ValueError, match="name"):
        run.mean("status")

    def curve(run: DeckSteps, stem: Path, beside: object) -> list[Path]:
        return [save(stem.with_name(f"{stem.name}.txt"), f"{run.steps[0].load!r}")]

    # As docs/contribute.md adds one: in one place, and the command tells of it.
    monkeypatch.setattr("atomistic.show.decks.WRITERS", [*WRITERS, curve])
    monkeypatch.setattr("atomistic.show.decks.save_figure", lambda _, stem: stem)
    assert main(["read", str(tmp_path / "deck"), "-o", str(tmp_path / "out")]) == 0
    assert f"file     {tmp_path / 'out' / 'deck.txt'}" in capsys.readouterr().out
    assert float((tmp_path / "out" / "deck.txt").read_text()) == run.steps[0].load
