"""Each claim of the paper beside what a sweep has found: reproduced or not, with numbers and how many points."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from continuum.paper import judges
from continuum.paper.judges import OFF, VISIBLE, Judged, Word
from continuum.paper.points import Points
from continuum.show.sheet import Sheet


@dataclass(frozen=True)
class ClaimVerdict:
    """One claim."""

    claim: str
    """In the paper's words, or nearly."""
    paper: str
    """What the paper says in numbers, and where."""
    word: Word
    found: str
    """What the sweep has, with numbers."""
    points: int
    """That it is judged by, all with A_rep >= 10 λ_s²."""
    bounds: str
    """What counts as reproduced; and, after a semicolon, as reproduced with a remark."""


@dataclass(frozen=True)
class _Claim:
    text: str
    paper: str
    judge: Callable[[Points], Judged | None]
    bounds: str = (
        f"geometric mean within {VISIBLE:.0%}, scatter by less than {2 * VISIBLE:.0%}; mean within a factor of {OFF:g}"
    )


def _claims() -> tuple[_Claim, ...]:
    return (
        _Claim(
            "kappa_rep is close to 2 without adhesion", "2 (Eq. 1); Persson 1.6, asperities 2.6", judges.kappa_rep,
            "within 0.2, half the way to the nearer rival; between the rivals",
        ),
        _Claim(
            "area is linear in load at low load", "exponent 1 (Fig. 2)", judges.linear,
            f"mean and scatter of exponents within {VISIBLE}, a decade with areas known to 25 %; within twice that",
        ),
        _Claim("the repulsive pressure is unchanged by adhesion", "1 (Fig. 3)", judges.pressure),
        _Claim(
            "mean gap against N_rep is unchanged by adhesion, where not sticky", "0: nearly unchanged", judges.mean_gap,
            "0.05 h_rms, which is 10 % of a load that falls by e in 0.5 h_rms; mean within twice that",
        ),
        _Claim("N_att = (w/range) A_att", "1 (Fig. 3)", judges.attraction),
        _Claim("A_att is a strip of width d_att along the perimeter", "1 (Eq. S-2)", judges.strip),
        _Claim("A_rep/A_att follows Eq. (4) where A_att < A_rep", "1 (Fig. 4)", judges.ratio),
        _Claim("1/kappa_att follows Eqs. (3) and (4)", "1 (Fig. 4)", judges.kappa_att),
        _Claim(
            "sticky if and only if 1/kappa_att of theory > 1/kappa_rep", "every surface of Fig. 4", judges.sticky,
            "no exception with κ_rep = 2; one in ten",
        ),
        _Claim(
            "d_rep changes by less than 25 % with area", "25 % over 2 - 3 decades (Fig. 3)", judges.constant,
            "every path; half of them",
        ),
        _Claim(
            "d_rep = 4h'/h'' within a factor of two", "0.5 - 2 (Fig. 3)", judges.diameter,
            "every point; all but one in ten",
        ),
        _Claim("P d = pi A_rep where d > 10 a0", "1 (Fig. S-2)", judges.perimeter),
        _Claim("the stiffness is lowered by kappa_rep/kappa, where not sticky", "1", judges.stiffness),
        _Claim(
            "Greenwood-Williamson theories fall orders of magnitude below N_max", "orders of magnitude (Fig. S-3)",
            judges.asperities, "half of the systems by more than one; any of them",
        ),
        _Claim(
            "kappa does not depend on lambda_L", "not at all (Fig. 4)", judges.roll_off,
            f"1/κ changes by less than {VISIBLE / 2}, a tenth of 1/κ_rep = 1/2; by less than twice its scatter",
        ),
    )  # fmt: skip


def claim_verdicts(points: Points) -> list[ClaimVerdict]:
    """All claims that a sweep can judge; of the others it is said that they were not looked at."""
    nothing: Judged = ("not looked at", "no points for it in this sweep", 0)
    found = ((claim, claim.judge(points) or nothing) for claim in _claims())
    return [ClaimVerdict(claim.text, claim.paper, *one, claim.bounds) for claim, one in found]


def verdict_sheet(found: list[ClaimVerdict]) -> Sheet:
    """The claims as a table."""
    columns = (
        "claim of the paper",
        "in the paper",
        "verdict",
        "found here",
        "points",
        "counts as reproduced; with a remark",
    )
    rows = [(v.claim, v.paper, v.word, v.found, v.points, v.bounds) for v in found]
    return Sheet.of("Claims of the paper", columns, rows)
