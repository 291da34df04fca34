"""The turn of a contact: the work of adhesion above which the surface is sticky."""

from __future__ import annotations

from dataclasses import dataclass

from continuum.front.states import State
from continuum.path.state import Event
from continuum.show.sheet import Sheet, pairs


@dataclass(frozen=True, eq=False)
class Turn:
    """The turn of a contact, or the last bracket of the search for it."""

    state: State
    """State at the given area whose load is nearest to zero."""

    @property
    def bracket(self) -> Event | None:
        """States below and above the turn, with their works as values; None if it was not found."""
        return self.state.found.turn

    @property
    def work(self) -> float:
        """Work of adhesion at the turn, in E* a0; NaN if it was not found.

        Within the bracket the load is taken as linear in the logarithm of the work.
        """
        return float("nan") if self.bracket is None else self.bracket.root

    @property
    def jumps(self) -> bool:
        """Whether the load jumps over zero: the surface snaps, and no state has zero load."""
        return self.bracket is not None and self.bracket.kind == "jump-in"

    @property
    def converged(self) -> bool:
        """Whether a bracket was found, with equilibria at both ends."""
        return self.state.converged

    @property
    def status(self) -> str:
        """How the search ended, in words."""
        return self.state.status

    def require(self) -> Turn:
        """Return the turn if it was found.

        Raises
        ------
        NotConvergedError
            Otherwise, with the reason.
        """
        self.state.require()
        return self

    def __repr__(self) -> str:
        return f"Turn(w {self.work:.4g} E* a0 at A_rep/A0 {self.state.area_rep:.4g}, {self.status})"

    def _repr_html_(self) -> str:
        return self.sheet()._repr_html_()

    def sheet(self) -> Sheet:
        """The bracket, with the loads at both ends."""
        rows = [("work of adhesion at the turn", f"{self.work:.4g} E* a0")]
        if self.bracket is not None:
            for name, side in (("below", self.bracket.before), ("above", self.bracket.after)):
                rows.append((f"{name}: work", f"{side.value:.5g} E* a0"))
                rows.append((f"{name}: load N/A0 at A_rep/A0 {side.area_rep:.4g}", f"{side.load:.3e} E*"))
        found = self.state.found
        rows.append(("FFT pairs", f"{found.search_pairs + found.solution.fft_pairs:.0f}"))
        return pairs("Turn", [*rows, ("status", self.status + (", the load jumps over zero" if self.jumps else ""))])
