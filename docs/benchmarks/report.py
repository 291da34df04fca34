"""Tables as Markdown and one figure, from the rows of a run, into a page that holds the two marker lines."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from continuum.show.plot import PAGE, SERIES, new_figure, save_figure, styled
from docs.benchmarks.cases import (
    ADHESION_LENGTHS,
    AREA,
    MEMORY_ALLOWED,
    PAIRS_ALLOWED,
)

__all__ = ["draw", "growth_exponent", "line", "short", "tables", "write"]

Row = dict[str, Any]
PEERS = ("Adhesion", "ContactMechanics", "SurfaceTopography", "tamaas", "aspher")
BEGIN, END = "<!-- tables: begin -->", "<!-- tables: end -->"
SHOWN = ("fft_pairs", "area", "cpu", "one_ratio", "all_ratio", "peak_mib")


def line(point: Row) -> str:
    """A point of a table in one line."""
    return " ".join(f"{key}={value}" for key, value in point.items())


def short(row: Row) -> str:
    """What matters of a row, while the rest runs."""
    if "theirs" in row and "ours" in row:
        return f"{row['theirs']['cpu']:.2f} / {row['ours']['cpu']:.2f} s"
    return ", ".join(
        f"{key}={row[key]}" if isinstance(row[key], str) else f"{key}={row[key]:.4g}" for key in SHOWN if key in row
    )


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A table in Markdown."""
    head = list(head)
    lines = [head, ["---"] * len(head), *rows]
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines)


def groups(rows: list[Row], *keys: str) -> dict[tuple[Any, ...], list[Row]]:
    """Rows that share the values of some keys, in order."""
    found: dict[tuple[Any, ...], list[Row]] = {}
    for row in rows:
        found.setdefault(tuple(row[key] for key in keys), []).append(row)
    return found


def growth_exponent(sizes: list[int], counts: list[float]) -> float:
    """Exponent a of counts ~ sizes^a, by least squares in logarithms; not a number from fewer than two sizes."""
    return float(np.polyfit(np.log(sizes), np.log(counts), 1)[0]) if len(sizes) > 1 else float("nan")


def work(rows: list[Row]) -> str:
    """Pairs by size and adhesion length, with bounds, growth and the worst point."""
    cells, medians = [], {}
    for (n, length), group in groups(rows, "n", "adhesion_length").items():
        counts = [row["fft_pairs"] for row in group]
        medians[n, length] = median(counts)
        bounds = PAIRS_ALLOWED.get(n)
        allowed = "" if bounds is None else f"{bounds[ADHESION_LENGTHS.index(length)]}"
        cells.append(
            [
                f"{n}²",
                f"{length:g}",
                ", ".join(f"{count:.1f}" for count in counts),
                f"**{median(counts):.1f}**",
                allowed,
                ", ".join(str(row["iterations"]) for row in group),
                ", ".join(f"{100 * row['area']:.2f}" for row in group),
                f"{median(row['cpu'] for row in group):.2f}",
                ", ".join(f"{row['search_pairs']:.0f}" for row in group),
                f"{median(row['search_cpu'] for row in group):.2f}",
            ]
        )
    head = ["grid", "l_a/a0", "FFT pairs, seeds 1, 2, 3", "median", "bound", "fine iterations", "area, %"]
    text = table([*head, "CPU s", "search, pairs", "search, CPU s"], cells)
    growth = []
    for length in ADHESION_LENGTHS:
        sizes = [n for n, at in medians if at == length]
        if len(sizes) > 1:
            exponent = growth_exponent(sizes, [medians[n, length] for n in sizes])
            growth.append(f"{exponent:.2f} (l_a = {length:g} a0)")
    worst = max(rows, key=lambda row: row["fft_pairs"])
    text += f"\nMedians grow as n^a with a = {', '.join(growth)}. " if growth else "\n"
    text += f"Worst point: {worst['fft_pairs']:.1f} pairs at {worst['n']}², "
    text += f"l_a = {worst['adhesion_length']:g} a0, seed {worst['seed']}.\n"
    return "### Work per load point\n\n" + text + "\n" + memory(rows)


def memory(rows: list[Row]) -> str:
    """Peak memory of the same processes, the largest on each grid."""
    cells = []
    for (n,), group in groups(rows, "n").items():
        worst = max(group, key=lambda row: row["peak_mib"])
        fields = worst["peak_mib"] * 2**20 / (8 * n * n)
        cells.append(
            [
                f"{n}²",
                f"**{worst['peak_mib']:.0f}**",
                f"{MEMORY_ALLOWED.get(n, '')}",
                f"{fields:.1f}",
                f"{worst['fft_pairs']:.1f}",
                f"{worst['cpu']:.1f}",
            ]
        )
    head = ["grid", "peak MiB", "bound", "in fields of n²", "FFT pairs", "CPU s"]
    return "### Peak memory of a load point\n\n" + table(head, cells)


def _wall(row: Row) -> float:
    """Time of an iteration by the clock, in ms: the transforms, and the arrays at the bandwidth reached."""
    return float(row["transforms_ms"] + row["arrays"] * 8e-6 * row["n"] ** 2 / row["reached_gb"])


def iteration(rows: list[Row]) -> str:
    """One grid alone with the count of arrays, all grids with the ratio only."""
    cells = [
        [
            f"{row['n']}²",
            f"{row['adhesion_length']:g}",
            f"{row['pair_ms']:.2f}",
            f"{row['block_pair_ms']:.2f}",
            f"{row['one_ms']:.2f}",
            f"**{row['one_ratio']:.2f}**",
            f"**{row['all_ratio']:.2f}**",
            f"{row['transforms_ms']:.2f}",
            f"{row['arrays']:.1f}",
            f"{row['stream_gb']:.1f}",
            f"{row['reached_gb']:.1f}",
            f"{100 * row['reached_gb'] / row['stream_gb']:.0f}",
            f"{_wall(row) / row['one_ms']:.2f}",
        ]
        for row in rows
    ]
    head = ["grid", "l_a/a0", "padded pair, ms", "same in blocks, ms", "iteration, ms", "ratio", "ratio, all grids"]
    head += ["in transforms, ms", "arrays moved", "stream, GB/s", "reached, GB/s", "%", "wall / CPU"]
    return "### Time of an iteration\n\n" + table(head, cells)


def _ratio(row: Row) -> float:
    return float(row["theirs"]["cpu"] / row["ours"]["cpu"])


def _two_digits(ratio: float) -> str:
    return f"{ratio:.0f}" if ratio >= 9.95 else f"{ratio:.1f}"


def _each(rows: list[Row], shown: Callable[[Row], str]) -> str:
    return ", ".join(map(shown, rows))


def _spread(rows: list[Row]) -> str:
    """Median and range of the ratios on each grid, and of all."""
    parts = [(f"on {n}²", group) for (n,), group in groups(rows, "n").items()] + [("in all", rows)]
    ratios = {where: [_ratio(row) for row in group] for where, group in parts}
    shown = {where: map(_two_digits, (median(of), min(of), max(of))) for where, of in ratios.items()}
    found = [f"{where} {middle} in the median, {least} to {most}" for where, (middle, least, most) in shown.items()]
    late = sum(not row["theirs"]["converged"] for row in rows)
    return f"\nThe ratio is {'; '.join(found)} ({len(rows)} states{f', {late} of them not converged' * bool(late)}).\n"


def adhesive(rows: list[Row]) -> str:
    """Ours and the adhesive peer from few contacts to many, at one mean gap and one residual."""
    cells = [
        [
            f"{n}²", f"{lambda_s:g}, {hurst:g}", f"{length:g}",
            _each(group, lambda row: f"{100 * row['states'][1]['pixels_rep'] / row['n'] ** 2:.2f}"),
            _each(group, lambda row: f"{row['theirs']['cpu']:.1f} / {row['ours']['cpu']:.2f}"),
            f"**{_each(group, lambda row: f'{_ratio(row):.0f}')}**",
            _each(group, lambda row: f"{row['ours']['fft_pairs']:.0f}"),
            _each(group, lambda row: str(row["pixels_different"])),
            _each(group, lambda row: _apart(row, "pressure")),
        ]
        for (n, lambda_s, hurst, length, _), group in groups(
            rows, "n", "lambda_s", "hurst", "adhesion_length", "asked"
        ).items()
    ]  # fmt: skip
    head = ["grid", "λ_s, H", "l_a/a0", "area, %", "CPU s, Adhesion / ours", "ratio", "FFT pairs, ours"]
    other = [row for row in rows if row["pixels_different"]]
    return (
        "### Adhesive contact, from few contacts to many, seeds 1, 2\n\n"
        + table([*head, "pixels differing", "rel. diff. of loads"], cells)
        + _spread(rows)
        + f"{len(other)} states have other pixels in contact; started from the peer's state, ours stays there to the "
        f"pixel in {sum(not row['lost'] for row in other)} of them.\n"
    )


def _apart(row: Row, key: str) -> str:
    theirs, ours = row["states"]
    return f"{abs(theirs[key] / ours[key] - 1):.0e}"


def hard_wall(rows: list[Row]) -> str:
    """Ours and the peers at the same mean pressures."""
    cells = [
        [
            f"{n}²", peer + ("" if all(row["theirs"]["converged"] for row in group) else " (not converged)"),
            f"{pressure:g}", _each(group, lambda row: f"{100 * row['states'][1]['pixels'] / row['n'] ** 2:.2f}"),
            _each(group, lambda row: f"{row['theirs']['cpu']:.2f} / {row['ours']['cpu']:.2f}"),
            f"**{_each(group, lambda row: _two_digits(_ratio(row)))}**",
            _each(group, lambda row: f"{row['ours']['fft_pairs']:.0f}"),
            _each(group, lambda row: f"{row['theirs']['peak_mib']:.0f} / {row['ours']['peak_mib']:.0f}"),
            _each(group, lambda row: str(row["pixels_different"])),
            _each(group, lambda row: " / ".join(f"{state['max_error']:.0e}" for state in row["states"])),
        ]
        for (n, peer, pressure), group in groups(rows, "n", "peer", "pressure").items()
    ]  # fmt: skip
    head = ["grid", "peer", "pressure, E*", "area, %", "CPU s, peer / ours", "ratio", "FFT pairs, ours", "peak MiB"]
    head += ["pixels differing", "largest error of the gap, a0"]
    title = "Hard wall at given mean pressures, λ_s = 16 a0, seeds 1, 2"
    each = [f"\n{peer}: {_spread(group).lstrip()}" for (peer,), group in groups(rows, "peer").items()]
    return f"### {title}\n\n{table(head, cells)}{''.join(each)}"


def threshold(rows: list[Row]) -> str:
    """The threshold, and what it costs beside one search for its area."""
    cells = []
    for (n, hurst, reach), group in groups(rows, "n", "hurst", "reach").items():
        ratios = [row["fft_pairs"] / row["search_pairs"] for row in group]
        cells.append((
            f"{n}²", f"{hurst:g}", f"core, {reach:g} h_rms" if reach else "paper's law",
            ", ".join(f"{row['over_energy']:.3f}" for row in group),
            ", ".join(f"{row['fft_pairs']:.0f}" for row in group), ", ".join(f"{row['solves']}" for row in group),
            ", ".join(f"{row['search_pairs']:.0f}" for row in group), ", ".join(f"{ratio:.1f}" for ratio in ratios),
        ))  # fmt: skip
    head = ("grid", "H", "wall", "w/U", "FFT pairs", "equilibria", "of the search for the area", "ratio")
    note = (
        "The threshold: work of adhesion at which the load at 1 % area changes its sign, bracketed to 2 %; seeds apart"
    )
    said = "Core: a spline on a core of 5 E*/a0, with this range."
    return f"### {note}\n\n{table(head, cells)}\n{said}\n"


def kinds(rows: list[Row]) -> str:
    """Pairs of one contact of each further kind."""
    cells = [
        (
            f"{n}²", kind, ", ".join(f"{row['fft_pairs']:.0f}" for row in group),
            f"**{median(row['fft_pairs'] for row in group):.0f}**", ", ".join(f"{row['solves']}" for row in group),
            ", ".join(f"{100 * row['area']:.4g}" for row in group),
            ", ".join(sorted({str(row["status"]).lower().replace("_", " ") for row in group})),
        )
        for (n, kind), group in groups(rows, "n", "kind").items()
    ]  # fmt: skip
    head = ("grid", "contact", "FFT pairs, seeds 1, 2, 3", "median", "equilibria", "A_rep, %", "status")
    note = "Without periodic images a pair is one of the grid of twice the points in each direction."
    return f"### Contacts of other kinds, from rest\n\n{table(head, cells)}\n{note}\n"


def searches(rows: list[Row]) -> str:
    """Pairs of a search for an area, and of a point of a path, over those of a solve from rest at the same mean gap."""
    cells = []
    for (n, length), group in groups(rows, "n", "adhesion_length").items():
        ratios = {
            area: [row["fft_pairs"] / row["cold"] for row in each] for (area,), each in groups(group, "area").items()
        }
        every = [ratio for area, each in ratios.items() if area != "path" for ratio in each]
        text = [", ".join(f"{ratio:.2f}" for ratio in each) for each in ratios.values()]
        cells.append([f"{n}²", f"{length:g}", *text, f"**{median(every):.2f}**", f"{max(every):.2f}"])
    areas = [f"{100 * row['area']:g} %" if row["area"] != "path" else "path" for row in rows]
    head = ("grid", "l_a/a0", *dict.fromkeys(areas), "median of the areas", "worst")
    note = (
        "Seeds 1 and 2. An area is found to 1 % of it. The last solve of a search is part of it. The path has 20 mean "
        "gaps on approach, from about 2 to 30 % of the area: the median of its points over that of solves from rest."
    )
    title = "Searches and paths, in solves from rest at the same mean gap"
    return f"### {title}\n\n{table(head, cells)}\n{note}\n"


def atoms(rows: list[Row]) -> str:
    """Our iteration and LAMMPS' minimisers from one start."""
    cells = []
    for row in rows:
        mine, other = row["ours"], row.get("lammps")
        beside = ["", "", "", "", ""]
        if other is not None:
            beside = [
                f"{other['evaluations']}",
                f"{other['cpu']:.1f}",
                f"**{other['evaluations'] / mine['evaluations']:.0f}**",
                f"{other['cpu'] / mine['cpu']:.1f}",
                f"{abs(other['load'] / mine['load'] - 1):.0e}",
            ]
        cells.append(
            [
                f"{row['n']}²",
                row["crystal"],
                f"{row['adhesion_length']:g}",
                f"{row['atoms']}",
                f"**{mine['evaluations']}**",
                f"{mine['cpu']:.1f}",
                f"{mine['force']:.0e}",
                f"{row['peak_mib']:.0f}",
                *beside,
            ]
        )
    head = ["surface", "crystal", "l_a/a0", "atoms", "evaluations", "CPU s", "largest force, E* a0²", "peak MiB"]
    head += ["LAMMPS alone, evaluations", "CPU s", "ratio of evaluations", "of CPU", "rel. diff. of loads"]
    return (
        "### Equilibrium of atoms\n\nA rough wall (h'rms = 0.1, lambda_s = 8 a0, lambda_L = L/2) at 10 % repulsive "
        "area on the lattice, whose solution both start from; to 1e-8 h'rms.  CPU time from the deck to the certified "
        "equilibrium, files included.\n\n" + table(head, cells)
    )


def walls(rows: list[Row]) -> str:
    """What a wall adds to an evaluation of the forces."""
    bare = {row["n"]: row["cpu"] for row in rows if row["kind"] == "none"}
    cells = [
        [
            f"{row['n']}²",
            row["kind"],
            f"{row['atoms']}",
            f"{1e3 * row['cpu']:.2f}",
            f"**{row['cpu'] / bare[row['n']]:.2f}**" if row["n"] in bare else "",
        ]
        for row in rows
    ]
    return (
        "### What a wall costs\n\nCPU time of one evaluation of the forces on springs under a sphere: without a wall, "
        "with laws as formulas of LAMMPS, as a function of the site or following the atoms, and in Python.\n\n"
        + table(["surface", "wall", "atoms", "CPU ms", "over none"], cells)
    )


def optimizers(rows: list[Row]) -> str:
    """Evaluations of the forces that optimizers need, and what the response of the slab cost."""
    names = ("GreensRelaxation", "PreconLBFGS", "LBFGS", "FIRE")
    cells = []
    for row in rows:
        mine = row["GreensRelaxation"]
        there = [row.get(name, {"evaluations": "", "converged": True}) for name in names]
        counts = [f"{one['evaluations']}" + ("" if one["converged"] else " (failed)") for one in there]
        beside = f"{row['LAMMPS']['evaluations']}" if "LAMMPS" in row else ""
        seconds = ", ".join(f"{row[name]['cpu']:.1f}" if name in row else "-" for name in names)
        measured = f"{mine['measured']} ({mine['cost']:.1f})"
        area = f"{100 * mine['contact']:.0f}"
        cells.append([row["slab"], f"{row['atoms']}", area, f"**{counts[0]}**", measured, *counts[1:], beside, seconds])
    head = ["slab", "atoms", "repulsive area, %", names[0], "response, of a small slab (of the whole)", *names[1:]]
    return (
        "### Optimizers\n\nEvaluations of the forces from the slab at rest to a largest force of 1e-5 E* a0² under a "
        "rough wall of the lattice sites (h'rms = 0.1, lambda_s = 8 a0, l_a = 0.005 a0).  The response of a slab is "
        "measured once, on a small slab of its cells; in brackets what that costs in evaluations of the whole.  "
        "LAMMPS: its conjugate gradients in a deck.  CPU s are those of the four optimizers, in this order.\n\n"
        + table([*head, "LAMMPS", "CPU s"], cells)
    )


TABLES: dict[str, Callable[[list[Row]], str]] = {
    "work": work,
    "iteration": iteration,
    "adhesive": adhesive,
    "hard_wall": hard_wall,
    "threshold": threshold,
    "kinds": kinds,
    "searches": searches,
    "atoms": atoms,
    "walls": walls,
    "optimizers": optimizers,
}


def _measured(results: Row, name: str) -> list[Row]:
    """Rows of a table that could be measured, by size, adhesion length, seed and peer."""
    rows = [row for row in results["rows"].get(name, []) if "skipped" not in row]
    return sorted(rows, key=lambda row: (row.get("n", 0), row.get("adhesion_length", 0.0), row.get("seed", 0)))


def tables(results: Row) -> str:
    """All tables as Markdown, and below each what is missing."""
    here, made = results["machine"], results["provenance"]
    peers = ", ".join(f"{name} {here[name]}" for name in PEERS)
    text = f"Made {results['date']} in {results['seconds'] / 60:.0f} min"
    if "provenance/git_commit" in made:
        changed = ", with changes not committed" if made["provenance/git_dirty"] else ""
        text += f", commit {made['provenance/git_commit'][:10]}{changed}"
    text += f". Machine: {here['processor']}, {here['cores']} cores, one used at a time. Python {here['python']}, "
    text += f"numpy {here['numpy']}, scipy {here['scipy']}, numba {here['numba']}, ducc0 {here['ducc0']}; {peers}.\n"
    parts = [text]
    for name, written in TABLES.items():
        rows = _measured(results, name)
        missing = [row for row in results["rows"].get(name, []) if "skipped" in row]
        hidden = ("skipped", "seconds", "sources")
        notes = "".join(
            f"- {line({k: v for k, v in row.items() if k not in hidden})}: {row['skipped']}\n" for row in missing
        )
        if rows or notes:
            parts.append((written(rows) if rows else f"### {name}\n") + (f"\nMissing:\n\n{notes}" if notes else ""))
    return "\n".join(parts)


def _sizes(axis: Axes, rows: list[Row]) -> None:
    sizes = sorted({row["n"] for row in rows})
    axis.set_xscale("log", base=2)
    axis.set_xticks(sizes, [f"{n}²" for n in sizes])
    axis.minorticks_off()
    axis.set_xlabel("points of the grid")


def _draw_work(axis: Axes, rows: list[Row]) -> None:
    for i, length in enumerate(ADHESION_LENGTHS):
        at = groups([row for row in rows if row["adhesion_length"] == length], "n")
        counts = {n: [row["fft_pairs"] for row in group] for (n,), group in at.items()}
        look = {"color": SERIES[i], "marker": "os^"[i]}
        axis.plot(list(counts), list(map(median, counts.values())), ms=5, label=f"$l_a$ = {length:g} $a_0$", **look)
        for n, values in counts.items():
            axis.plot([n] * len(values), values, linestyle="", ms=2.5, **look)
            if n in PAIRS_ALLOWED:
                axis.plot(n, PAIRS_ALLOWED[n][i], "_", ms=18, mew=2, color=SERIES[i])
    axis.plot([], [], "_", ms=12, mew=2, color="0.4", label="bound")
    axis.plot([], [], "o", ms=2.5, color="0.4", label="each seed (line: median)")
    title = f"work near {100 * AREA:g} % area"
    axis.set(ylabel="FFT pairs per load point", title=title, ylim=(0, None))
    _below(axis)
    _sizes(axis, rows)


def _below(axis: Axes) -> None:
    """A legend below the labels, where no curve runs."""
    axis.legend(ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.2))


def _draw_iteration(axis: Axes, rows: list[Row]) -> None:
    for (length,), group in groups(rows, "adhesion_length").items():
        color = SERIES[ADHESION_LENGTHS.index(length)]
        for key, style, name in (("one_ratio", "o-", "one grid"), ("all_ratio", "o:", "all grids")):
            at = [row["n"] for row in group], [row[key] for row in group]
            axis.plot(*at, style, color=color, label=f"{name}, $l_a$ = {length:g} $a_0$")
    axis.axhline(2.0, color="0.6", ls="--", lw=1, label="bound")
    axis.set(ylabel="time / time of a padded FFT pair", title="time of an iteration", ylim=(0, None))
    _below(axis)
    _sizes(axis, rows)


def _draw_memory(axis: Axes, rows: list[Row]) -> None:
    at = {n: max(row["peak_mib"] for row in group) / 2**10 for (n,), group in groups(rows, "n").items()}
    axis.plot(list(at), list(at.values()), "o-", color=SERIES[0], label="largest process")
    for n in at.keys() & MEMORY_ALLOWED.keys():
        axis.plot(n, MEMORY_ALLOWED[n] / 2**10, "_", ms=18, mew=2, color=SERIES[0])
    axis.set_yscale("log", base=2)
    ticks = (0.125, 0.25, 0.5, 1, 2, 4, 8)
    axis.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axis.plot([], [], "_", ms=12, mew=2, color=SERIES[0], label="bound")
    axis.set(ylabel="peak memory (GiB)", title="memory of the whole process, libraries included")
    _below(axis)
    _sizes(axis, rows)


def _draw_peers(axis: Axes, rows: list[Row]) -> None:
    same = groups(rows, "peer", "n")
    y = np.arange(len(same))
    theirs, ours = (
        [median(row[side]["cpu"] for row in group) for group in same.values()] for side in ("theirs", "ours")
    )
    axis.barh(y - 0.2, theirs, 0.38, color=SERIES[1], label="peer")
    axis.barh(y + 0.2, ours, 0.38, color=SERIES[0], label="continuum")
    for i, group in enumerate(same.values()):
        axis.text(theirs[i] * 1.1, i - 0.2, f"{_two_digits(median(map(_ratio, group)))}x", va="center")
    axis.set_yticks(y, [f"{peer}, {n}²" for peer, n in same])
    axis.invert_yaxis()
    title = "one problem, one accuracy, one thread\n(number: ratio of the times)"
    axis.set(xscale="log", xlabel="CPU time of a load point (s)", title=title, xlim=(None, 6 * max(theirs)))
    _below(axis)


@styled
def draw(results: Row, stem: Path) -> Path:
    """Pairs, iteration time, memory and CPU times of ours and the peers in one figure, as far as they were measured."""
    work = _measured(results, "work")
    panels: list[tuple[Callable[[Axes, list[Row]], None], list[Row]]] = [
        (_draw_work, work),
        (_draw_iteration, _measured(results, "iteration")),
        (_draw_memory, work),
        (_draw_peers, _measured(results, "adhesive") + _measured(results, "hard_wall")),
    ]
    figure = new_figure(PAGE, 6.4)
    for axis, (panel, rows) in zip(figure.subplots(2, 2).ravel(), panels, strict=True):
        if rows:
            panel(axis, rows)
        else:
            axis.set_axis_off()
    return save_figure(figure, stem, own=True)


def write(results: Row, folder: Path) -> str:
    """Tables between the marker lines of ``studies/benchmarks.md`` of a folder, and the figure; returns the tables."""
    text = tables(results)
    page = folder / "studies" / "benchmarks.md"
    before, rest = page.read_text().split(BEGIN)
    after = rest.split(END)[1]
    page.write_text(f"{before}{BEGIN}\n\n{text}\n{END}{after}")
    draw(results, folder / "benchmarks")
    return text
