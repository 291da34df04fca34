"""Input files: every fault at once, with its place; what makes two runs the same."""

from __future__ import annotations

import contextlib
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from continuum.front.cli import main
from continuum.inputs.reading import load
from continuum.inputs.toml import ConfigError, find, text_of, value_of
from continuum.store.identity import identity, resolved
from continuum.store.runs.build import build
from continuum.store.runs.config import RunConfig
from tests.problems import SMALL


def faults(path: Path) -> str:
    with pytest.raises(ConfigError) as caught:
        load(path, RunConfig)
    return str(caught.value)


FAULTS = [
    ("seed = 3", "sead = 3", 12, "surface.sead = 3", "did you mean seed"),
    ("seed = 3", "seed = 1.5", 12, "surface.seed = 1.5", "whole number"),
    ("seed = 3", 'seed = "3"', 12, 'surface.seed = "3"', "whole number"),
    ("rms_slope = 0.1", "rms_slope = nan", 9, "surface.rms_slope = nan", "finite"),
    ("rms_slope = 0.1", "rms_slope = inf", 9, "surface.rms_slope = inf", "finite"),
    ("lambda_s = 6.0", "lambda_s = -6.0", 10, "surface.lambda_s = -6.0", "greater than 0"),
    ("lambda_s = 6.0", "lambda_s = 1.9", 10, "surface.lambda_s = 1.9", "two spacings, 2 a0"),
    ("lambda_L = 12.0", "lambda_L = 24.5", 11, "surface.lambda_L = 24.5", "at most the period, 24 a0"),
    ("lambda_L = 12.0", "lambda_L = 5.0", 10, "surface.lambda_s = 6.0", "at most lambda_L"),
    ("period = [24, 30]", "period = [24, 29.5]", 4, "grid.period = [24, 29.5]", "whole number of a0"),
    ("n = [24, 30]", "n = [25, 30]", 3, "grid.n = [25, 30]", "multiple of the period"),
    ("n = [24, 30]", "n = [24, 1]", 3, "grid.n = [24, 1]", "from 2"),
    ("n = [24, 30]", "n = [0, 30]", 3, "grid.n[0] = 0", "from 1 to 65536"),
    ("n = [24, 30]", "n = 0.5", 3, "grid.n = 0.5", "from 1 to 65536"),
    ("hurst = 0.8", "hurst = 1.2", 8, "surface.hurst = 1.2", "less than 1"),
    ("adhesion_length = 0.005", "range = 3.5", 16, "wall.range = 3.5", "at most 3 in an input"),
    ("adhesion_length = 0.005", "adhesion_length = 1", 16, "wall.adhesion_length = 1", "0.375"),
    ("adhesion_length = 0.005", "adhesion_length = 0.1\nrange = 0.1", 16, "adhesion_length", "exactly one"),
    ("adhesion_length = 0.005", "", 14, "wall.adhesion_length", "exactly one"),
    ('kind = "self-affine"', 'kind = "selfaffine"', 7, 'surface.kind = "selfaffine"', 'mean "self-affine"'),
    ('kind = "self-affine"', 'kind = "file"\npath = "no.npy"', 8, 'surface.path = "no.npy"', "existing file"),
    (
        'response = "half-space"',
        'response = "crystal"\nc11 = 1\nc12 = 2\nc44 = 1',
        21,
        "substrate.c12 = 2",
        "not stable",
    ),
    (
        'response = "half-space"',
        'response = "layered-half-space"\nlayers = [{thickness = 2, contact_modulus = 70, poisson = 0.3}]\n'
        "base = {contact_modulus = 200, poisson = 0.3}",
        20,
        "substrate.layers",
        "in E*: one is 1, or some are above and some below, not all from 70 to 200",
    ),
    (
        'response = "half-space"',
        'response = "layered-half-space"\nlayers = [{thickness = 2, contact_modulus = 1, poisson = 0.6}]\n'
        "base = {contact_modulus = 2, poisson = 0.3}",
        20,
        "substrate.layers[0].poisson = 0.6",
        "less than or equal to 0.5",
    ),
    (
        'response = "half-space"\nmean = "clamped"',
        'response = "non-periodic-half-space"',
        22,
        'loading.control = "mean-gap"',
        "another control",
    ),
    (
        'response = "half-space"',
        'response = "non-periodic-half-space"',
        20,
        'substrate.mean = "clamped"',
        "belongs to another kind",
    ),
    (
        'law = "lennard-jones-spline"\nadhesion_length = 0.005',
        'law = "hard"\nhardness = 0.05',
        23,
        'loading.control = "mean-gap"',
        "an imprint changes the mean gap",
    ),
    (
        'law = "lennard-jones-spline"\nadhesion_length = 0.005',
        'law = "hard"\nhardness = -1',
        16,
        "wall.hardness = -1",
        "greater than 0",
    ),
    ('mean = "clamped"', "", 18, "substrate.mean", "required"),
    ('mean = "clamped"', 'mean = "clampd"', 20, 'substrate.mean = "clampd"', '"clamped", "free"'),
    ("targets = [1.6, 1.4,\n           1.2]", "targets = [1.6,\n 1.8]", 24, "loading.targets", "decreasing"),
    ("targets = [1.6, 1.4,\n           1.2]", "targets = {from = 1.6, to = 1.2}", 24, "targets", "a range: from"),
    ("targets = [1.6, 1.4,\n           1.2]", "targets = [1.6,\n nan]", 25, "targets[1] = nan", "finite"),
    ("retract = true", 'retract = "yes"', 26, 'loading.retract = "yes"', "true or false"),
    ("fields = true", "[output.fields]", 29, "output.fields", "true or false"),
]


def test_a_fault_is_named_with_its_place(small: Path) -> None:
    for old, new, line, key, words in FAULTS:
        assert old in SMALL
        small.write_text(SMALL.replace(old, new))
        message = faults(small)
        assert f"{small}:{line}: " in message
        assert key in message
        assert words in message
        assert "allowed:" in message


@pytest.mark.parametrize(
    ("given", "place", "allowed"),
    [
        ('"x"', 'loading.area_tolerance = "x"', "greater than 0 and less than 1, or a list "),
        ("2.0", "loading.area_tolerance = 2.0", "greater than 0 and less than 1, or a list "),
        ("[]", "loading.area_tolerance = []", "less than 1, or a list of at least 1 entries"),
        ('[0.1, "x", 0.1]', 'loading.area_tolerance[1] = "x"', "a finite number greater than 0 and less than 1 ("),
    ],
)
def test_of_a_key_that_may_have_several_types_there_is_one_fault(
    small: Path, given: str, place: str, allowed: str
) -> None:
    small.write_text(SMALL.replace("retract = true", f"area_tolerance = {given}"))
    message = faults(small)
    assert f"{small}: 1 fault\n{small}:26: {place}\n" in message
    assert allowed in message


def surface_faults(small: Path, surface: str) -> str:
    """What is said of an input with another table [surface]."""
    before, after = SMALL.split("[surface]\n")[0], SMALL.split("[wall]\n")[1]
    small.write_text(f"{before}[surface]\n{surface}\n[wall]\n{after}")
    with pytest.raises(ConfigError) as caught:
        build(load(small, RunConfig))
    return str(caught.value)


SPECTRUM = 'kind = "self-affine"\nhurst = 0.8\nlambda_s = 6.0\nlambda_L = 12.0\nseed = 3\n'


FAULTS_OF_SURFACES = [
    (SPECTRUM + "rms_slope = 1e6", "rms_slope = 1000000.0"),
    (SPECTRUM + "rms_slope = 1e-300", "rms_slope = 1e-300"),
    (SPECTRUM + "rms_height = 1e6", "rms_height = 1000000.0"),
    (SPECTRUM + "rms_height = 1e-300", "rms_height = 1e-300"),
    ('kind = "sine"\namplitude = 1e6\nwaves = [1, 0]', "amplitude = 1000000.0"),
    ('kind = "sine"\namplitude = 0.1\nwaves = [13, 0]', "waves = [13, 0]"),
    ('kind = "sine"\namplitude = 0.1\nwaves = [1.5, 0]', "waves[0] = 1.5"),
    ('kind = "sphere"\nradius = 1e-3', "radius = 0.001"),
    ('kind = "sphere"\nradius = 1e-320', "radius = 1e-320"),
    ('kind = "cylinder"\nradius = 1e-3', "radius = 0.001"),
    ('kind = "punch"\nflat_radius = 100.0\nedge_radius = 3.0', "flat_radius = 100.0"),
    ('kind = "punch"\nflat_radius = 3.0\nedge_radius = 1e-3', "edge_radius = 0.001"),
    ('kind = "file"\npath = "flat.npy"', 'path = "flat.npy"'),
    ('kind = "file"\npath = "huge.npy"', 'path = "huge.npy"'),
]


def test_a_fault_of_a_surface_is_at_the_key_that_is_wrong(small: Path) -> None:
    """Whatever made a slope impossible, "kind" was blamed for it."""
    for surface, key in FAULTS_OF_SURFACES:
        rough = np.random.default_rng(1).normal(size=(24, 30))
        for name, factor in (("flat", 0.0), ("huge", 1e200)):
            np.save(small.parent / f"{name}.npy", factor * rough)
        message = surface_faults(small, surface)
        assert f"surface.{key}\n" in message
        assert message.count("allowed:") == 1


def test_a_range_of_targets_is_the_list_of_its_values(tmp_path: Path) -> None:
    """The same run by identity, integers or not."""
    found, ways = [], ("[2, 1.75, 1.5]", "{from = 2, to = 1.5, count = 3}", "{from = 2.0, to = 1.5, step = -0.25}")
    for i, targets in enumerate(ways):
        path = tmp_path / f"{i}.toml"
        path.write_text(SMALL.replace("[1.6, 1.4,\n           1.2]", targets))
        found.append(load(path, RunConfig))
    assert {config.loading.targets for config in found} == {(2.0, 1.75, 1.5)}
    assert len({identity(config) for config in found}) == 1


VALUES = st.recursive(
    st.booleans()
    | st.integers(-(2**63), 2**63 - 1)
    | st.floats(allow_nan=False)
    | st.text("aZ 1\"'\\\n\té²", max_size=6),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text('ab ."é', min_size=1, max_size=3), inner, max_size=3)
    ),
    max_leaves=8,
)


@given(VALUES)
def test_a_value_written_as_an_input_has_it_is_read_back(value: object) -> None:
    assert value_of(text_of(value)) == value


@given(VALUES, st.sampled_from(["\nx = 1", "\n[solver]\nthreads = 2", " # more", "# more", ", 2", "\n# more"]))
def test_nothing_that_follows_a_value_is_dropped(value: object, rest: str) -> None:
    text = text_of(value) + rest
    assert value_of(text) == text


def test_a_key_of_another_table_is_sent_there(small: Path) -> None:
    small.write_text(
        SMALL.replace("n = [24, 30]", "n = [24, 30]\nthreads = 2").replace("seed = 3", "seed = 3\nradius = 2")
    )
    message = faults(small)
    assert re.search(r"grid\.threads = 2\n.*\n.*belongs into \[solver\]", message)
    assert re.search(r"surface\.radius = 2\n.*\n.*belongs to another kind of \[surface\]", message)


def test_all_faults_are_told_at_once(small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = SMALL
    for old, new in [
        ("n = [24, 30]", "n = [24, 0]"),
        ("hurst = 0.8", "hurst = -1"),
        ("seed = 3", "seed = true"),
        ("adhesion_length", "adhesion_lenght"),
        ('control = "mean-gap"', 'control = "gap"'),
        ("[output]", "[outputs]"),
    ]:
        text = text.replace(old, new)
    small.write_text(text)
    assert main(["run", str(small), "-o", str(small.parent / "out")]) == 2
    error = capsys.readouterr().err
    lines = [int(found) for found in re.findall(rf"^{re.escape(str(small))}:(\d+): ", error, re.MULTILINE)]
    assert {3, 8, 12, 16, 23, 28} <= set(lines)
    assert lines == sorted(lines)
    assert "Traceback" not in error
    assert list(small.parent.iterdir()) == [small]


@pytest.mark.parametrize("text", ["[grid\n", "n = = 2", "\x00", "[a]\n[a]\n", "x = 1" * 3])
def test_what_is_no_toml_is_said(small: Path, text: str) -> None:
    small.write_text(text)
    assert "TOML" in faults(small)


def test_a_missing_or_foreign_file_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(tmp_path / "none.toml")]) == 2
    assert f"{tmp_path / 'none.toml'}" in capsys.readouterr().err
    assert main(["check", str(tmp_path)]) == 2
    binary = tmp_path / "picture.png"
    binary.write_bytes(bytes(range(256)))
    assert main(["check", str(binary)]) == 2
    assert "Traceback" not in capsys.readouterr().err


KEYS = re.findall(r"^(\w+) = ", SMALL, re.MULTILINE)
garbage = st.one_of(
    st.integers().map(str),
    st.floats(allow_nan=False, allow_infinity=False).map(repr),
    st.sampled_from(["nan", "-inf", "[]", "{}", '""', "true", "[[1, 2], 3]", "1979-05-27", "{a = {b = [nan]}}"]),
    st.text(st.characters(blacklist_categories=("Cs", "Cc"), blacklist_characters="'"), max_size=8).map(
        lambda text: f"'{text}'"
    ),
    st.lists(st.integers(-5, 70000), max_size=3).map(str),
)


@given(st.dictionaries(st.sampled_from(KEYS), garbage, min_size=1, max_size=4))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_whatever_the_values_a_file_is_valid_or_its_faults_are_told(small: Path, values: dict[str, str]) -> None:
    text = SMALL.replace("[1.6, 1.4,\n           1.2]", "[1.6]")
    for key, value in values.items():
        text = re.sub(rf"^{key} = .*$", lambda _, k=key, v=value: f"{k} = {v}", text, flags=re.MULTILINE)
    small.write_text(text, encoding="utf-8")
    with contextlib.suppress(ConfigError):  # and nothing else
        assert len(identity(load(small, RunConfig))) == 64
    assert list(small.parent.iterdir()) == [small]


def changed(small: Path, old: str, new: str) -> str:
    assert old in SMALL
    small.write_text(SMALL.replace(old, new))
    return identity(load(small, RunConfig))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("[output]\nfields = true", "[output]\nfields = false"),
        ("[output]\nfields = true", ""),
        ("[output]", "[solver]\nthreads = 2\n[output]"),
        ("period = [24, 30]\n", ""),
        ("# a comment", "# another\n\n"),
        ("hurst = 0.8\nrms_slope = 0.1", "rms_slope = 0.10\nhurst = 8e-1"),
        ("[output]", "[solver]\ntolerance = 1e-6\n[output]"),
    ],
)
def test_what_does_not_change_results_does_not_change_the_identity(small: Path, old: str, new: str) -> None:
    before = identity(load(small, RunConfig))
    assert changed(small, old, new) == before
    moved = small.rename(small.with_name("other.toml"))
    assert identity(load(moved, RunConfig)) == before


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("seed = 3", "seed = 4"),
        ("hurst = 0.8", "hurst = 0.7"),
        ("n = [24, 30]", "n = [48, 60]"),
        ("0.005", "0.0050001"),
        ('mean = "clamped"', "mean = 1.0"),
        ('"mean-gap"', '"separation"'),
        ("1.2]", "1.3]"),
        ("retract = true", "retract = false"),
        ("[output]", "[solver]\ntolerance = 1e-7\n[output]"),
    ],
)
def test_what_changes_results_changes_the_identity(small: Path, old: str, new: str) -> None:
    before = identity(load(small, RunConfig))
    assert changed(small, old, new) != before


def test_a_newer_key_leaves_the_identity_of_stored_results(small: Path) -> None:
    """Results that were stored before the key came are still found."""
    known = load(small, RunConfig)
    assert "rms_height" not in known.plain(identity=True)["surface"]
    assert known.plain()["surface"]["rms_height"] is None
    assert changed(small, "rms_slope = 0.1", "rms_height = 0.1") != identity(known)
    assert load(small, RunConfig).plain(identity=True)["surface"]["rms_height"] == 0.1


@pytest.mark.parametrize("rescale", ["true", "false"])
def test_a_surface_of_a_given_height_is_that_of_a_given_slope_stretched(small: Path, rescale: str) -> None:
    sloping = load(small, RunConfig).surface
    small.write_text(SMALL.replace("rms_slope = 0.1", f"rms_height = 0.3\nrescale = {rescale}"))
    config = load(small, RunConfig)
    grid = config.grid.build()
    heights, expected = config.surface.build(grid), config.surface.expected(grid)
    ratio = heights / sloping.build(grid)
    np.testing.assert_allclose(ratio, ratio[0, 0], rtol=1e-9)
    assert expected is not None
    assert expected.rms_height == pytest.approx(0.3, rel=1e-12)
    # One realisation on so few modes scatters by tens of per cent; rescaled, it has its height exactly.
    assert (abs(heights.std() - 0.3) < 1e-15) == (rescale == "true")


def test_a_surface_has_a_slope_or_a_height(small: Path) -> None:
    for text in ("rms_slope = 0.1\nrms_height = 0.3", ""):
        small.write_text(SMALL.replace("rms_slope = 0.1", text))
        with pytest.raises(ConfigError, match="exactly one of rms_slope and rms_height"):
            load(small, RunConfig)


def test_a_file_of_heights_counts_by_its_content(small: Path) -> None:
    a, b = small.with_name("a.npy"), small.with_name("b.npy")
    heights = np.random.default_rng(1).normal(size=(24, 30))
    np.save(a, heights)
    np.save(b, heights)
    text = re.sub(r'kind = "self-affine".*?seed = 3', 'kind = "file"\npath = "a.npy"', SMALL, flags=re.DOTALL)
    small.write_text(text)
    first = identity(load(small, RunConfig))
    assert "a.npy" in resolved(load(small, RunConfig))
    small.write_text(text.replace("a.npy", "b.npy"))
    assert identity(load(small, RunConfig)) == first
    np.save(b, heights + 1e-9)
    assert identity(load(small, RunConfig)) != first


def test_inputs_of_the_package_are_found_from_anywhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert find("inputs/smoke/adhesive.toml").is_file()
    assert load("inputs/smoke/adhesive.toml", RunConfig).loading.retract
    # A file of one's own of that name comes first.
    own = tmp_path / "inputs" / "smoke" / "adhesive.toml"
    own.parent.mkdir(parents=True)
    own.write_text("")
    assert find("inputs/smoke/adhesive.toml").resolve() == own
