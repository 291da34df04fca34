"""Figures and verdicts: contacts that are made to follow the paper are found to, and such that do not are not."""

from __future__ import annotations

import itertools
import re
import tomllib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from pandas import DataFrame, concat, read_csv

from continuum.paper import relations
from continuum.paper.claims import CLAIMS, Finding, claim_verdicts, stored_points
from continuum.paper.figures import FIGURES, save_drawing
from continuum.paper.page import page_text, plot_figure, write_page
from continuum.paper.points import FigureError, SweepData, sweep_points
from continuum.show import plot
from continuum.store.sweeps.axes import Axis, System
from continuum.store.sweeps.bisection import Bisection
from continuum.store.sweeps.collect import PointTable
from continuum.store.sweeps.listing import SweepListing
from continuum.store.sweeps.measured import COLUMNS
from continuum.theory import paper
from docs.studies.judge import judged_again
from docs.studies.tables import points_of
from tests.printed import faults_in_print

LENGTHS = (0.0, 0.0005, 0.005, 0.05)
AREAS = np.geomspace(0.01, 0.15, 5)
ROOT = Path(__file__).parents[4]


def system(slope: float, lambda_s: float, length: float, kappa_rep: float, strip: float) -> list[dict[str, float]]:
    """Contacts of one surface that follow every relation of the paper, but for two that may be changed."""
    reach, curvature = np.sqrt(24 * length), slope * 4 / (0.7 * lambda_s)
    d = paper.contact_diameter(slope, curvature)
    rows = []
    for step, area in enumerate(AREAS):
        pushed = slope * area / kappa_rep
        ratio = paper.area_ratio(slope, d, reach) if length else np.inf
        attracted = strip * area / ratio if length else 0.0
        pulled = attracted * length / reach if length else 0.0
        load, around = pushed - pulled, np.pi * area * 4096**2 / d
        rows.append({
            "step": step, "converged": 1, "retracting": 0, "target": area, "area_rep": area, "area_att": attracted,
            "load_rep": pushed, "load_att": pulled, "load": load, "mean_gap": 10 - 2 * np.log(pushed),
            "stiffness": load / 2, "tangent_stiffness": load / 2, "pressure_att": length / reach if length else np.nan,
            "kappa": slope * area / load, "kappa_rep": kappa_rep, "perimeter": around, "diameter": d, "chord": d,
            "kappa_att": slope * area / pulled if pulled else np.inf, "rms_height": 3.0, "rms_slope": slope,
            "rms_curvature": curvature, "range": reach, "effective_range": reach, "work_of_adhesion": length,
            "width": paper.attraction_width(slope, d, reach) if length else np.nan,
        })  # fmt: skip
    return rows


def table(
    kappa_rep: float = 2.0,
    strip: float = 1.0,
    more: Mapping[str, tuple[Any, ...]] | None = None,
    slopes: tuple[float, ...] = (0.1, 0.15, 0.3),
) -> PointTable:
    keys = ("surface.rms_slope", "surface.lambda_s", "wall.adhesion_length", *(more or {}))
    axes = (slopes, (16.0, 32.0), LENGTHS, *(more or {}).values())
    places = list(itertools.product(*axes))
    systems = tuple(System(f"{i:024d}", dict(zip(keys, p, strict=True)), 1.0, 1.0) for i, p in enumerate(places))
    rows = [row for place in places for row in system(*place[:3], kappa_rep, strip)]
    values = np.array([[row.get(name, np.nan) for name in COLUMNS] for row in rows])
    listing = SweepListing(
        "made", tuple(Axis((k,), tuple((v,) for v in a)) for k, a in zip(keys, axes, strict=True)),
        {"surface.hurst": 0.8, "surface.seed": 1, "grid.n": [4096, 4096], "grid.period": [4096.0, 4096.0],
         "surface.lambda_L": 2048.0, "wall.law": "lennard-jones-spline"}, systems,
    )  # fmt: skip
    index = np.repeat(np.arange(len(places)), AREAS.size)
    made = {"version 0": len(places)}
    return PointTable(listing, tuple(s.key for s in systems), index, values, np.ones(len(places)), 0, 0, (), made)


BARE = "kappa_rep is close to 2 without adhesion"
STICKY = "sticky if and only if 1/kappa_att of theory > 1/kappa_rep"
OTHER_LAWS = "other laws of the wall follow Eqs. (3) and (4) with the range of Eq. (S-5)"
MAUGIS = "Eqs. (3) and (4) hold even where lambda_Maugis exceeds 1"
GAP = "the gap outside a contact is that of Eq. (S-1), x^(3/2), where it reaches the range"
RANGE = "the range of Eq. (S-5) is that of the spline within 6 %"


def found_of(text: str, points: DataFrame) -> Finding:
    """Of one claim alone: of all it takes half a second."""
    (claim,) = (claim for claim in CLAIMS if claim.text == text)
    return claim.finding(points)


def test_contacts_that_follow_the_paper_reproduce_it() -> None:
    found = claim_verdicts(sweep_points(table()))
    words = {claim.text: finding.word for claim, finding in found if "Greenwood" not in claim.text}
    for untested in ("kappa does not depend on lambda_L", OTHER_LAWS, MAUGIS):
        assert words.pop(untested) == "not tested"
    assert set(words.values()) == {"reproduced"}, words
    assert all(finding.points > 0 for claim, finding in found if claim.text in words)


def test_contacts_that_do_not_are_found_out() -> None:
    soft = sweep_points(table(kappa_rep=8.0))
    assert found_of(BARE, soft).word == "not reproduced"
    assert "κ_rep = 8" in found_of(BARE, soft).found
    points = sweep_points(table(kappa_rep=2.5))
    hard = points.assign(law="hard", kappa_rep=2.0)
    both = concat([points, hard], ignore_index=True)
    assert "wall hard: 2; wall lennard-jones-spline: 2.5" in found_of(BARE, both).found
    # Sticky where 1/κ_att > 1/8, predicted where it is > 1/2.
    assert found_of(STICKY, soft).word != "reproduced"
    # What is missed is told by size: here λ_s = 16 and 32 alike, three slopes each, at the strongest adhesion.
    assert re.search(r"sticky but not predicted \(λ_s = 16: \d+, 32: \d+\)", found_of(STICKY, soft).found)
    wide = sweep_points(table(strip=3.0))
    assert found_of("A_att is a strip of width d_att along the perimeter", wide).word == "not reproduced"
    assert found_of("A_rep/A_att follows Eq. (4) where A_att < A_rep", wide).word == "not reproduced"
    assert found_of("N_att = (w/range) A_att", wide).word == "reproduced"


@pytest.mark.parametrize(
    ("claim", "given", "column"),
    [
        (OTHER_LAWS, {"law": "lennard-jones-9-3"}, "kappa_att"),
        (OTHER_LAWS, {"law": "attraction-on-core", "shape": "exponential"}, "kappa_att"),
        (MAUGIS, {"diameter": 1e5}, "kappa_att"),
        (GAP, {}, "width"),
    ],
)
def test_ratios_of_the_further_claims_are_held_against_one(claim: str, given: dict[str, Any], column: str) -> None:
    points = sweep_points(table()).assign(**given)
    for factor, word in ((1.0, "reproduced"), (1.3, "reproduced with a remark"), (2.0, "not reproduced")):
        found = found_of(claim, points.assign(**{column: points[column] * factor}))
        assert found.word == word
        assert found.points > 0


def test_one_law_that_is_off_is_not_outweighed_by_another() -> None:
    points = sweep_points(table())
    long = points.assign(law="lennard-jones-9-3", kappa_att=points.kappa_att / 2)
    short = points.assign(law="lennard-jones-12-6", kappa_att=points.kappa_att * 2)
    found = found_of(OTHER_LAWS, concat([long, short], ignore_index=True))
    assert found.word == "not reproduced"
    assert "lennard-jones-12-6: 0.5, lennard-jones-9-3: 2" in found.found


def test_the_range_of_the_spline_is_told() -> None:
    points = sweep_points(table())
    for factor, word in ((1.0566, "reproduced"), (1.07, "not reproduced")):
        rows = points.assign(effective_range=points["range"] * factor)
        assert found_of(RANGE, rows).word == word


def test_right_on_average_by_too_much_here_and_too_little_there_is_not_reproduced() -> None:
    points = sweep_points(table())
    wrong = points.assign(area_att=points.area_att * np.where(points.lambda_s == 16, 1.6, 1 / 1.6))
    found = found_of("A_rep/A_att follows Eq. (4) where A_att < A_rep", wrong)
    assert found.word == "not reproduced"
    assert "geometric mean 1" in found.found
    assert "λ_L/λ_s = 64: 1.6" in found.found
    assert "λ_L/λ_s = 128: 0.625" in found.found


def test_theories_of_asperities_are_judged_with_the_number_of_systems_that_never_pull() -> None:
    claim = "Greenwood-Williamson theories fall orders of magnitude below N_max"
    points = sweep_points(table())
    found = found_of(claim, points)
    systems = points[points.length > 0].groupby("system").load.min()
    assert found.points == len(systems)
    assert f"of the {(systems < 0).sum()} systems of {len(systems)} that pull" in found.found
    assert f"{(systems >= 0).sum()} never pull on approach" in found.found


def test_few_surfaces_and_one_kind_of_contact_are_no_test() -> None:
    points = sweep_points(table())
    two = points[points.slope == 0.1]
    assert two.surface.nunique() == 2
    assert {finding.word for _, finding in claim_verdicts(two)} == {"not tested"}
    weak = points[points.length < 0.05]
    for text in (STICKY, "Greenwood-Williamson theories fall orders of magnitude below N_max"):
        assert found_of(text, weak).word == "not tested"
    # A period that the paper did not look at says nothing of its independence of λ_L.
    short = points.assign(lambda_L=np.where(points.lambda_s == 16, 128.0, 256.0))
    assert found_of("kappa does not depend on lambda_L", short).word == "not tested"


def test_a_cloud_that_scatters_is_no_line_whatever_its_mean() -> None:
    points = sweep_points(table())
    factor = np.where(points.index % 2 == 0, 2.0, 0.5)
    found = found_of("N_att = (w/range) A_att", points.assign(pressure_att=points.pressure_att * factor))
    assert found.word == "not reproduced"


def test_the_page_has_all_verdicts_of_all_sweeps_in_one_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("continuum.paper.page._meant", lambda data: iter(()))
    good, soft = (
        SweepData(table(**given), tmp_path / name) for name, given in (("good", {}), ("Soft_1", {"kappa_rep": 8.0}))
    )
    page, *_ = write_page([good, soft], tmp_path / "paper.md")
    lines = page.read_text().splitlines()
    row = next(line for line in lines if line.startswith("| kappa_rep is close to 2"))
    assert row.split(" | ")[1:] == ["[reproduced](#sweep-good)", "[not reproduced](#sweep-soft1) |"]
    assert "| *bandwidths λ_L/λ_s* | 64 - 128 | 64 - 128 |" in lines
    assert "## Sweep `good`" in lines
    own = lines[lines.index("### Verdicts of `good`") : lines.index("### Verdicts of `Soft_1`")]
    assert [line for line in own if line.startswith("*Not tested*") and "kappa does not depend on lambda_L" in line]
    assert not [line for line in own if line.startswith("|") and "not tested" in line]
    # The answer in words comes before all tables, and counts the sweeps that say so.
    answers = [line for line in lines[: lines.index("## Sweep `good`")] if line.startswith("* ")]
    (bad,) = (line for line in answers if line.startswith("* **Not reproduced by some**"))
    assert "kappa_rep is close to 2 without adhesion (1 of 2 sweeps)" in bad
    (well,) = (line for line in answers if line.startswith("* **Reproduced by every sweep that tests it**"))
    assert "N_att = (w/range) A_att" in well
    assert min(i for i, line in enumerate(lines) if line.startswith("|")) > lines.index("## Verdicts")


def test_points_with_too_few_asperities_do_not_count() -> None:
    points = sweep_points(table())
    few = points["area_rep"] * 4096**2 < 10 * points.lambda_s**2
    assert not (points.valid & few).any()
    assert points.reference.sum() == 24
    assert (points["area_rep"][points.reference] == AREAS[0]).all()


# Axes that a figure asks for, beside those of the table.
AXES: dict[str, dict[str, tuple[Any, ...]]] = {
    "finite-size": {"surface.lambda_L": (512.0, 1024.0, 2048.0)},
    "lambda-L": {"surface.lambda_L": (512.0, 1024.0, 2048.0)},
    "other-potentials": {"wall.law": ("lennard-jones-spline", "lennard-jones-9-3")},
}


def test_a_sweep_is_judged_from_the_table_beside_the_page_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("continuum.paper.page._meant", lambda data: iter(()))
    data = SweepData(table(kappa_rep=2.3, strip=1.6), tmp_path / "made")
    page, numbers = write_page([data], tmp_path / "paper.md")
    assert numbers.name == "paper-made-points.csv"
    text = page.read_text()
    assert len(re.findall(r"^\* \*\*(?:Not r|R)eproduced|^\* \*\*Not tested", text, re.MULTILINE)) == 4, "one of each"
    assert judged_again(page) == text
    # A table of before a claim was made lacks its columns: it is not tested there.
    numbers.write_text(read_csv(numbers).drop(columns="width").to_csv(index=False))
    assert found_of(GAP, stored_points(numbers)).word == "not tested"


ALIKE = ("finite-size", "lambda-L")
"""Figures that are drawn as ``continuum-limit`` is."""
MEASURED = ROOT / "docs" / "measured" / "paper.md"


def test_verdicts_of_the_measured_page_are_by_the_rules_of_today() -> None:
    """Of four sweeps, which test each claim that any sweep of the page tests."""
    text, tested = MEASURED.read_text(), set[str]()
    for name in ("figure3", "stiffness-reduced", "other-potentials-reduced", "bandwidth"):
        points = stored_points(points_of(name))
        found = page_text({name: ""}, {name: points}).partition("## Verdicts\n")[2].partition("###")[2]
        assert f"###{found}".strip() in text
        tested |= {claim.text for claim in CLAIMS if f"| {claim.text} |" in found}
    (untested,) = (line for line in text.splitlines() if line.startswith("* **Not tested**"))
    assert {claim.text for claim in CLAIMS if claim.text not in untested} == tested


@pytest.mark.long
def test_the_measured_page_is_that_of_the_rules_of_today() -> None:
    assert judged_again(MEASURED) == MEASURED.read_text()


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.long] if name in ALIKE else [])
        for name, figure in FIGURES.items()
        if not figure.whole
    ],
)
def test_every_figure_is_made_for_print_and_has_its_numbers_beside_it(name: str, tmp_path: Path) -> None:
    drawing = FIGURES[name].make(SweepData(table(more=AXES.get(name)), tmp_path))
    assert faults_in_print(drawing.figure) == []
    # Not an empty page: axes and letters alone are darker than grey on more than a hundredth of it.
    canvas = drawing.figure.canvas
    assert isinstance(canvas, FigureCanvasAgg)
    assert np.mean(np.asarray(canvas.buffer_rgba())[..., :3].min(axis=-1) < 128) > 0.01
    lines = drawing.sheet.csv().splitlines()
    assert "l_a (a0)" in lines[0].split(",")
    assert len(lines) > 4
    # What is drawn is explained.
    assert drawing.figure.legends


@pytest.mark.parametrize("name", ["figure2", pytest.param("figure4", marks=pytest.mark.long)])
def test_a_figure_is_drawn_from_the_table_beside_it_alone(name: str, tmp_path: Path) -> None:
    drawing = FIGURES[name].make(SweepData(table(), tmp_path))
    _, numbers = save_drawing(drawing, tmp_path / name)
    again = plot.styled(FIGURES[name].draw)(read_csv(numbers))
    for one, other in zip(again.axes, drawing.figure.axes, strict=True):
        lines = [[(str(line.get_label()), line.get_xydata()) for line in axis.lines] for axis in (one, other)]
        assert lines[0]
        np.testing.assert_equal(*lines)
        assert one.get_xlabel() == other.get_xlabel()


def searched(slopes: tuple[float, ...], kappa_rep: float) -> PointTable:
    """Contacts whose slope was searched for the threshold."""
    made = table(kappa_rep, slopes=slopes)
    search = Bisection("surface.rms_slope", "load", 0.01, 0.0, slopes[0], slopes[-1], 0.05, "log")
    return replace(made, listing=replace(made.listing, bisection=search))


def test_the_border_of_figure_4_is_where_a_search_found_the_threshold() -> None:
    kappa_rep = 2.5
    points = sweep_points(searched((0.05, 0.1, 0.18, 0.185, 0.19, 0.195, 0.2, 0.3), kappa_rep))
    points = points.query("reference and length == 0.05 and lambda_s == 16")
    assert points.search.nunique() == 1
    found = relations.kappas(points)
    (threshold,) = found[found["threshold"]].to_dict("records")
    for name in ("1/kappa_att theory", "1/kappa_att", "1/kappa_rep"):  # they follow the paper: all are the same there
        assert threshold[name] == pytest.approx(1 / kappa_rep, rel=1e-3)
    assert 0.19 < threshold["h'rms"] < 0.195
    figure = plot.styled(relations.draw_kappas)(found)
    lines = {line.get_label(): line.get_xdata() for line in figure.axes[0].lines}
    assert lines["threshold, by bisection of 1 surfaces"][0] == threshold["1/kappa_att theory"]
    assert lines[r"the same, $\kappa_\mathrm{rep}$ as measured"][0] == pytest.approx(1 / kappa_rep)


def test_what_figure_4_does_not_show_is_not_in_its_legend() -> None:
    found = relations.kappas(sweep_points(table()).query("reference and area_att > 0"))
    for shown, there in ((found, True), (found[found["1/kappa_att theory"] < 0.2], False)):
        (legend,) = plot.styled(relations.draw_kappas)(shown).legends
        said = [text.get_text() for text in legend.get_texts()]
        for entry in ("sticky by theory", "sticky: mean load"):
            assert any(entry in text for text in said) == there


def test_a_search_of_another_column_is_no_search_for_the_threshold() -> None:
    made = searched((0.1, 0.15, 0.3), 2.0)
    assert made.listing.bisection is not None
    other = replace(made.listing, bisection=replace(made.listing.bisection, column="kappa_rep"))
    assert (sweep_points(replace(made, listing=other)).search == -1).all()
    assert not relations.kappas(sweep_points(table()).query("reference and area_att > 0"))["threshold"].any()


def test_figure_2_marks_the_largest_tension_on_the_way_back_where_there_are_asperities_enough() -> None:
    back = {"seed": 1, "way": "retraction", "l_a (a0)": 0.1}
    numbers = DataFrame([
        back | {"N/(h' E* A0)": load, "A_rep/A0": area, "A_rep >= 10 lambda_s^2": enough}
        for load, area, enough in [(-0.01, 0.05, True), (-0.03, 0.03, True), (-0.05, 0.001, False)]
    ])  # fmt: skip
    there = {"way": "approach"}
    axis = plot.styled(relations.draw_area_against_load)(numbers).axes[0]
    (ring,) = [line for line in axis.lines if line.get_label() == "largest tension on the way back"]
    assert (ring.get_xdata()[0], ring.get_ydata()[0]) == (-0.03, 0.03)
    said = FIGURES["figure2"].said
    assert "on approach and back;" in said(numbers)
    assert "on approach and back (at l_a = 0.1);" in said(
        concat([numbers, numbers.assign(**there, **{"l_a (a0)": 0.0})])
    )
    assert "on approach;" in said(numbers.assign(**there))
    assert "The largest tension is 0.05 h' E* A0." in said(numbers)


def test_systems_that_never_pull_stand_on_the_axis_of_figure_s3_as_arrows() -> None:
    numbers = DataFrame({
        "H": 0.8, "h'rms": 0.1, "lambda_s (a0)": 8.0, "l_a (a0)": [0.05, 0.005, 0.005], "seed": 1,
        "A_rep >= 10 lambda_s^2": True, "h_rms/delta_c": [2.0, 5.0, 6.0], "N_max/(N P_c)": [0.5, 0.0, 0.0],
    })  # fmt: skip
    axis = plot.styled(relations.draw_tensions)(numbers).axes[0]
    arrows = [line for line in axis.lines if line.get_marker() == relations.NEVER]
    assert sorted(x for line in arrows for x in line.get_xdata()) == [5.0, 6.0]
    assert {y for line in arrows for y in line.get_ydata()} == {axis.get_ylim()[0]}
    (legend,) = axis.figure.legends
    assert any("never pulls on approach, 2 of 3" in text.get_text() for text in legend.get_texts())
    assert "1 of 3 pull" in FIGURES["figure-s3"].said(numbers)


def test_no_point_of_figure_2_is_within_the_tolerance_of_two_targets() -> None:
    path = tomllib.loads((ROOT / "inputs" / "sweep" / "figure2.toml").read_text(encoding="utf-8"))["loading"]
    targets, slack = np.array(path["targets"]), np.array(path["area_tolerance"])
    assert np.all((targets * (1 + slack))[:-1] < (targets * (1 - slack))[1:])


def test_a_figure_that_is_none_says_which_there_are(tmp_path: Path) -> None:
    with pytest.raises(FigureError, match="figure4"):
        plot_figure("figure5", tmp_path)
