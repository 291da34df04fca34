"""The command ``atomistic elastic``: what it prints, and one clear message for whatever is wrong."""

from pathlib import Path

import pytest

from atomistic.front.cli import main
from tests.printed import faults_in_print

INPUTS = Path(__file__).parents[3] / "inputs" / "crystals"


def run(capsys, *arguments: str) -> tuple[int, str, str]:
    code = main(["elastic", *arguments])
    return code, *capsys.readouterr()


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("springs", ["1.030727", "0.515364", "0.977834", "1.024967", "exact lattice sums"]),
        ("lennard-jones", ["1.5579987", "86.30011", "49.49494", "ε/σ³", "+0.011573"]),
        ("copper", ["3.6149251", "169.8781", "122.5861", "76.20615", "GPa", "127.7329", "135.1827", "145.1288"]),
    ],
)
def test_it_prints_the_crystal_and_draws_it(capsys, tmp_path, drawn, name, shown):
    code, out, _ = run(capsys, str(INPUTS / f"{name}.toml"), "-o", str(tmp_path))
    assert code == 0
    for text in shown:
        assert text in out
    assert drawn[f"{name}-contact-modulus"].axes[0].has_data()


def test_it_compares_the_lattice_with_the_continuum(capsys, tmp_path, monkeypatch, drawn):
    monkeypatch.setenv("STICKINESS_CACHE", str(tmp_path / "cache"))
    code, out, _ = run(capsys, str(INPUTS / "springs.toml"), "-o", str(tmp_path), "--lattice", "64")
    assert code == 0
    assert "+3.511 %" in out  # at 8 a0
    assert len(list((tmp_path / "cache").glob("lattice-*.h5"))) == 1
    assert {name: faults_in_print(figure) for name, figure in drawn.items()} == {
        "springs-contact-modulus": [],
        "springs-discreteness": [],
    }


def test_other_tables_of_an_input_do_not_matter(capsys, tmp_path, drawn):
    (tmp_path / "a.toml").write_text('separation = 1\n[slab]\nn = 3\n[interatomic]\nkind = "springs"\n')
    assert run(capsys, str(tmp_path / "a.toml"), "-o", str(tmp_path))[0] == 0


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("", "interatomic is not given"),
        ('kind = "sprigns"', 'did you mean "springs"'),
        ('kind = "springs"\nstiffness = 1.0', "interatomic.stiffness"),
        ('kind = "lennard-jones"\ncutoff = 0.1', "greater than or equal to 1.2 and less than or equal to 10, in sigma"),
        (
            'kind = "lennard-jones"\ntruncation = "mdf"',
            "interatomic.inner is not given allowed: a finite number greater than or equal to 1, in sigma",
        ),
        ('kind = "lennard-jones"\ntruncation = "cut"', 'one of "smooth/linear", "smooth", "mdf"'),
        ('kind = "lennard-jones"\ncutoff = nan', "finite number"),
        ('kind = "eam"', "interatomic.file is not given"),
        ('kind = "eam"\nfile = "Cu_mishin.eam.alloy"', "did you mean Cu_mishin1.eam.alloy"),
        ('kind = "eam"\nfile = 3', "the name of a potential file"),
        ('kind = "eam"\nfile = "SiC.tersoff"', "is not a potential of pair_style eam"),
        (
            'kind = "eam"\nfile = "Ni_u3.eam"\nelement = "Cu"',
            "holds the elements Ni: the element 'Cu' is not among them",
        ),
        ('kind = "eam"\nfile = "CuNi.eam.alloy"', "holds the elements Ni, Cu: no element was named"),
        ('kind = "eam"\nfile = "Ni_u3.eam"\nelement = "Ni; shell ls"', "text of this form"),
        ('kind = "eam"\nfile = "Fe_mm.eam.fs"', "not fcc at its minimum: bcc"),
    ],
)
def test_bad_inputs_get_one_message_and_write_nothing(capsys, tmp_path, text, match):
    (tmp_path / "bad.toml").write_text(f"[interatomic]\n{text}\n" if text else "")
    code, out, err = run(capsys, str(tmp_path / "bad.toml"), "-o", str(tmp_path / "out"))
    assert code == 2
    assert out == ""
    assert match in " ".join(err.split())
    assert "Traceback" not in err
    assert not (tmp_path / "out").exists()


def test_a_lattice_too_small_or_too_large_is_refused(capsys, tmp_path):
    code, out, err = run(capsys, str(INPUTS / "springs.toml"), "-o", str(tmp_path), "--lattice", "16")
    assert (code, out) == (2, "")
    assert "--lattice of 48 to 256" in err
