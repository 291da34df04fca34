"""The verdict as a colour, and w with its threshold on an axis: what the page of the browser and the report show."""

import numpy as np

from continuum.maps.verdict.criteria import Answer
from continuum.maps.verdict.prediction import PredictionNumbers

COLOURS: dict[Answer, str] = {"sticky": "#a84800", "not sticky": "#005a92", "undecided": "#5c5c5c"}
"""Colour of each verdict, under white letters."""
_PARTS = "#5d9fc9", "#c4c4c4", "#d98e4f"
"""Colours of the axis, under black letters: not sticky, undecided, sticky."""
_LEFT, _WIDTH = 20.0, 440.0
_BESIDE = 90.0
"""Distance of two labels below which one stands above the other."""


def verdict_axis(prediction: PredictionNumbers) -> str:
    """SVG of w and w_c in mJ/m² on a logarithmic axis, whose parts are not sticky, undecided and sticky.

    Empty without a threshold.
    """
    found, work = prediction.threshold, 1e3 * prediction.contact.work_of_adhesion
    if found is None or not found.work > 0 or not work > 0:
        return ""
    threshold, low, high = (1e3 * one for one in (found.work, found.low, found.high))
    ends = min(work, low or threshold) / 2, max(work, high if np.isfinite(high) else threshold) * 2

    def at(value: float) -> float:
        share = np.log(np.clip(value, *ends) / ends[0]) / np.log(ends[1] / ends[0])
        return _LEFT + float(share) * _WIDTH

    right, here, there = _LEFT + _WIDTH, at(work), at(threshold)
    edges = _LEFT, at(low), max(at(high), at(low) + 1), right
    bars = "".join(
        f'<rect x="{start:.1f}" y="40" width="{max(end - start, 0):.1f}" height="16" fill="{colour}"/>'
        for start, end, colour in zip(edges[:-1], edges[1:], _PARTS, strict=True)
    )
    ticks = "".join(f'<text x="{at(value):.1f}" y="74">{value:g}</text>' for value in _ticks(*ends))
    above = 14 if abs(here - there) < _BESIDE else 28
    return (
        f'<svg viewBox="0 0 480 96" role="img" text-anchor="middle" font-size="14" '
        f'aria-label="w = {work:.3g}, w_c = {threshold:.3g} mJ/m²">{bars}'
        f'<line x1="{there:.1f}" x2="{there:.1f}" y1="34" y2="62" stroke="#000" stroke-width="2"/>'
        f'<text x="{there:.1f}" y="{above}">w_c {threshold:.3g}</text>'
        f'<path d="M{here:.1f} 48l-7 -14h14z"/><text x="{here:.1f}" y="28" font-weight="700">w {work:.3g}</text>{ticks}'
        '<text x="240" y="92">work of adhesion (mJ/m²): not sticky, undecided, sticky</text></svg>'
    )


def _ticks(low: float, high: float) -> list[float]:
    """Round numbers on a logarithmic axis: 1, 2 and 5 of each decade, or 1 alone if there are many decades."""
    decades = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1)
    every = max(1, len(decades) // 8)
    digits = (1, 2, 5) if high < 300 * low else (1,)
    values = [digit * 10.0**decade for decade in decades[::every] for digit in digits]
    return [value for value in values if low <= value <= high]
