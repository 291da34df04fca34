"""The answer of a prediction in statements of one line each: the solution first, then the theories."""

from collections.abc import Iterator, Sequence
from functools import partial

from continuum import units
from continuum.model.grid import Grid
from continuum.runs.cost import pair_seconds
from continuum.show.prediction_data import ranges, remedy_options
from continuum.sticky.criteria import AREA, CRITERIA, Answer
from continuum.sticky.prediction import WIDE, Prediction
from continuum.sticky.probe import ProbePullOff
from continuum.sticky.record import outside, turning_margin
from continuum.sticky.simulate import UnresolvedError, resolvable, shortest_range
from continuum.sticky.solved_turn import PATIENCE, expected_pairs
from continuum.sticky.verdict import (
    SURE,
    Verdict,
    answer_at,
    answer_of,
    continued_verdict,
    judge,
    turn_shift,
    unmeasured,
)
from continuum.topography.faults import MapFault

length = partial(units.readable, quantity="length", digits=3)
pressure = partial(units.readable, quantity="pressure", digits=3)
per_area = partial(units.readable, quantity="energy_per_area", digits=3)
force = partial(units.readable, quantity="force", digits=3)
"""Lengths, pressures, energies per area and forces as statements and tables have them."""
NEAR, NEAR_COARSE = 1.5, 2.0
"""Factors of the turn within which a solved answer is called near it, where the pixels resolve the range and where not.
With pixels four times finer the turns of eight surfaces moved by up to 1.3 and 1.8."""
CONFORMS = 0.1
"""Part of w below which the energy of full contact is called small."""
BESIDE = 4.0
"""Time of an FFT pair in the solver over that of its transforms alone: 2.3 to 6.5 were measured."""


def statements(prediction: Prediction) -> list[str]:
    """The answer, one line each without a full stop: at most nine.

    They are: faults of the maps, unmeasured waves if they change the solution, the answer of the solver and its factor
    to the turn, the verdict of the theories, the energy of full contact, the pull-off force of a probe if given,
    and the paper's criterion.
    """
    verdict, solved = judge(prediction), prediction.solved_answer
    lines = [_faults(prediction), _unmeasured_of_solved(prediction, solved), *_solver(prediction, solved)]
    lines.append(_theories(prediction, verdict, solved))
    if verdict.turn is not None:
        lines.append(f"By their record the answer changes at {_turning(prediction, verdict.turn)}")
    lines.append(_stays(prediction))
    probe = prediction.probe
    lines += [_full_contact(prediction), "" if probe is None else _probe(prediction, probe), _paper(prediction)]
    return [line for line in lines if line]


def solving(prediction: Prediction, state: bool) -> str:
    """What will be solved and its time on one core, or why the state at the given w cannot be solved."""
    facing = prediction.facing
    shape = tuple(n * (1 if facing.periodic else 2) for n in facing.grid.shape)
    images = "" if facing.periodic else ", the map and its mirror images"
    images += "" if prediction.mended is None else ", as measured and with its faults corrected"
    text = (
        f"solving for the work of adhesion at which the load at {100 * AREA:g} % area vanishes, on {shape[0]} x "
        f"{shape[1]} points{images}: about {_seconds(prediction, shape[0], shape[1])} s, to a factor of three; "
        "--no-solve leaves it out"
    )
    if not state:
        return f"{text}; given up after {PATIENCE:g} times that unless --solve is given"
    try:
        instead = resolvable(facing, prediction.interface)[1]
    except UnresolvedError as error:
        return f"{text}; at the given w nothing will be solved: {error}"
    return f"{text}; then the contact at the given w, often longer{f': {instead}' if instead else ''}"


def _seconds(prediction: Prediction, nx: int, ny: int) -> str:
    contact = prediction.contact
    adhesion_length = 0.5 * (contact.conformal_energy or 0.0) / contact.contact_modulus
    resolved = contact.range >= shortest_range(prediction.facing, adhesion_length)
    pairs = expected_pairs(nx * ny, resolved=resolved)
    pairs *= 1 if prediction.mended is None else 2
    return _times(max(BESIDE * pairs * pair_seconds(Grid((nx, ny), (float(nx), float(ny)))), 1.0))


def _begun(text: str) -> str:
    return text[0].upper() + text[1:]


def _times(ratio: float) -> str:
    """A factor with two significant digits, without an exponent."""
    return f"{float(f'{ratio:.2g}'):.12g}" if ratio >= 1e-4 else f"{ratio:.2g}"


def percent(probability: float) -> str:
    """A probability in whole per cent, never 0 or 100 %, and on the same side of :data:`SURE` as the answer."""
    whole = round(100 * probability)
    if not 1 <= whole <= 99:
        return "less than 1 %" if whole < 1 else "more than 99 %"
    if answer_at(whole / 100) != answer_at(probability):
        whole += 1 if whole < 100 * probability else -1
    return f"{whole} %"


def _faults(prediction: Prediction) -> str:
    if not prediction.faults:
        return ""
    found = "; ".join(fault.text for fault in prediction.faults)
    remedies = " ".join(dict.fromkeys(remedy_options(fault) for fault in prediction.faults if fault.remedy))
    return f"Faulty map: {found}{f' (correct with {remedies})' if remedies else ''}"


def _unmeasured_of_solved(prediction: Prediction, solved: Answer | None) -> str:
    corrected = prediction.mended or prediction
    waves = corrected.continuation
    if solved is None or solved == "undecided" or waves is None or answer_of(prediction) == solved:
        return ""
    shift, beyond = turn_shift(corrected), continued_verdict(corrected)
    found = f"the theories find it {beyond.answer} ({'; '.join(beyond.why)})"
    if prediction.turn is not None and shift is not None:
        found = f"the turn of the theories moves by a factor of {_times(shift)}"
    return (
        f"Undecided, though solved on the map: waves below {length(waves.measured)} were not measured, and with the "
        f"spectrum continued to {length(waves.smallest)} {found}: measure below {length(waves.measured)}"
    )


def _stays(prediction: Prediction) -> str:
    beyond, waves = unmeasured(prediction), prediction.continuation
    if beyond is None or waves is None or beyond.changes is not None:
        return ""
    return (
        f"Waves below {length(waves.measured)} were not measured: with the spectrum continued to "
        f"{length(waves.smallest)} it stays {beyond.verdict.answer}"
    )


def _solver(prediction: Prediction, solved: Answer | None) -> Iterator[str]:
    """The solution, and the factors by which it is away from the turn."""
    if solved is None:
        return
    turn, measured = prediction.turn, prediction.measured_turn
    if faults := prediction.open_by_faults:
        yield f"Undecided, though solved on the map: {_open(prediction, faults)}"
        return
    corrected = "" if prediction.mended is None else " with its faults corrected"
    if turn is None:
        only = "at the given work of adhesion only: its turn was not found"
        yield f"{_begun(solved)}, solved on the map{corrected} {only}"
        return
    w = prediction.contact.work_of_adhesion
    if solved == "undecided":
        yield (
            f"Undecided, solved on the map{corrected}: w = {per_area(w)} lies between {per_area(turn.work)}, where the "
            f"load at {100 * AREA:g} % repulsive area vanishes with the shortest range that the pixels resolve, and "
            f"{per_area(turn.most)}, where it would with the range given"
        )
        return
    bound = turn.most if solved == "sticky" else turn.work
    ratio = w / bound
    close = NEAR_COARSE if turn.coarse else NEAR
    near = ", but near the turn" if max(ratio, 1 / ratio) < close else ""
    snaps = ", as the surface snaps" if turn.jumps else ""
    yield (
        f"{_begun(solved)}{near}, solved on the map{corrected}: w = {per_area(w)} is {_times(ratio)} times the "
        f"{per_area(bound)} at which the load at {100 * AREA:g} % repulsive area changes its sign{snaps}"
        f"{'' if measured is None else f' (as measured, at {per_area(measured.work)})'}"
    )
    modulus = pressure(prediction.contact.contact_modulus * ratio)
    other = (
        f"It would not be sticky with w below {per_area(bound)}, with E* above {modulus}"
        if solved == "sticky"
        else f"It would be sticky with w above {per_area(bound)}, with E* below {modulus}"
    )
    coarse = (
        f" (the pixels resolve ranges down to {length(turn.range)} only: by the law of the turn it lies between "
        f"{per_area(turn.work)} and {per_area(turn.most)})"
    )
    yield f"{other}, or with {_heights(ratio)}{coarse if turn.coarse else ''}"


def _open(prediction: Prediction, faults: Sequence[MapFault]) -> str:
    """Why faults leave open what was solved."""
    turn, measured, w = prediction.turn, prediction.measured_turn, per_area(prediction.contact.work_of_adhesion)
    kinds = " and ".join(fault.kind for fault in faults)
    if excluded := [fault.excludes for fault in faults if fault.excludes]:
        return f"{kinds}: {excluded[0]}"
    if not any(fault.remedy for fault in faults):
        return f"{kinds}, without remedy: the answer would have to hold at {WIDE:g} times more or less w"
    if turn is None or measured is None:
        said = {"as measured": measured, "with the faults corrected": turn}
        return f"its turn was not found {' and '.join(how for how, one in said.items() if one is None)}"
    return (
        f"the load at {100 * AREA:g} % repulsive area changes its sign at {per_area(measured.work)} as measured and at "
        f"{per_area(turn.work)} with the faults corrected, so that the answers at w = {w} differ"
    )


def _heights(ratio: float) -> str:
    """A margin in w as a factor of the heights, whose square the energy of full contact is proportional to."""
    return f"heights about {_times(ratio**0.5)} times as large"


def _turning(prediction: Prediction, work: float) -> str:
    contact = prediction.contact
    ratio = contact.work_of_adhesion / work
    return (
        f"w = {per_area(work)}, at E* = {pressure(contact.contact_modulus * ratio)}, or with {_heights(ratio)}: "
        f"w is {_times(ratio)} times that of the turn"
    )


def _theories(prediction: Prediction, verdict: Verdict, solved: Answer | None) -> str:
    chance = None if verdict.probability is None else f"{percent(verdict.probability)} sticky by the measured records"
    why = f" ({': '.join(filter(None, (chance, '; '.join(verdict.why))))})"
    if solved is None:
        unsolved = prediction.unsolved
        not_solved = f", by the theories only, as it was not solved: {unsolved}" if unsolved else ""
        return f"{_begun(verdict.answer)}{why}{not_solved}"
    if verdict.answer in (solved, "undecided") or solved == "undecided":
        return f"Theories: {verdict.answer}{why}"
    return (
        f"But theories: {verdict.answer}{why}.  Solver and theories differ here: theories use the moments of the map, "
        "the solver the summits that touch"
    )


def _full_contact(prediction: Prediction) -> str:
    contact = prediction.contact
    energy, w = contact.conformal_energy, contact.work_of_adhesion
    if energy is None:
        return ""
    cost = f"U = {per_area(energy)}, {_times(energy / w)} times w = {per_area(w)}"
    if energy <= CONFORMS * w:
        return f"Full contact costs little, {cost}: the surface conforms to the roughness that the map shows"
    if energy < w:
        return f"Full contact costs {cost}: it pays, and leaves w - U = {per_area(w - energy)}"
    return f"Full contact would cost {cost}: it does not pay, and only parts of the surface touch"


def _probe(prediction: Prediction, probe: ProbePullOff) -> str:
    w = prediction.contact.work_of_adhesion
    start = f"Pull-off force of a probe of radius {length(probe.radius)}: "
    kind = f"Maugis' parameter {_times(probe.maugis)}"
    if prediction.excluding and prediction.solved_answer is None:
        return f"{start}no number, as neither the theories nor the solver judge this map"
    if probe.least is not None and probe.apparent is not None:
        interval = " to ".join(dict.fromkeys((force(probe.least), force(probe.most))))
        text = (
            f"{start}{interval}, with an apparent work of adhesion between w - U = {per_area(probe.apparent)} and "
            f"w = {per_area(w)} ({kind})"
        )
        return text + ("" if probe.rim is None else f"; on approach, before full contact, below {force(probe.rim)}")
    if probe.rim is not None:
        return f"{start}not sticky; the force of the bare rough surface is below {force(probe.rim)} ({kind})"
    return (
        f"{start}at most {force(probe.most)}, that with the full w ({kind}); U exceeds w, so that there is no apparent "
        "work of adhesion w - U and no lower bound"
    )


def _paper(prediction: Prediction) -> str:
    estimate = prediction.paper
    criteria = (CRITERIA[estimate.key],)
    record = "its record has no such surfaces"
    if not outside(criteria, prediction.contact):
        low, high = (turning_margin(criteria, prediction.contact, p) for p in (1 - SURE, SURE))
        record = f"its record has the turn between {low:.2g} and {high:.2g} (10 and 90 %)"
    doubt = ", but it is out of its range (see the warnings)"
    if prediction.excluding:
        doubt = ", but its record has other surfaces"
    elif ranges(prediction)[estimate.key].startswith("yes"):
        doubt = "" if estimate.valid else ", judged with smaller heights"
    mended = prediction.mended
    more = "" if mended is None else f".  With the faults corrected its margin is {mended.paper.margin:.3g}"
    return f"The paper's Eq. (6) has a margin of {estimate.margin:.3g}; {record}{doubt}{more}"
