"""Mutation tests: one change at a time in the physics, and whether any test near it fails.

``make mutants`` draws a hundred changes at random and takes half an hour on two cores.  A change that no test sees is a
test that is missing, a line that nobody needs, or one that means the same: the list at the end says which they are.
"""

from __future__ import annotations

import argparse
import ast
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from difflib import unified_diff
from functools import cache
from itertools import islice
from pathlib import Path
from queue import SimpleQueue
from typing import Any

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names

ROOT = Path(__file__).parent.parent
ROOMS = ("continuum/model", "continuum/solve", "continuum/measure", "continuum/theory", "atomistic/response",
         "atomistic/lammps")  # fmt: skip
SIGNS = "Add_Sub|Sub_Add|Mul_Div|Div_Mul|Pow_Mul|Mul_Add"
COMPARISONS = "Lt_Gt|Gt_Lt|LtE_Gt|GtE_Lt|Eq_NotEq|NotEq_Eq"
CHANGES = re.compile(
    rf"core/(NumberReplacer|ReplaceBinaryOperator_({SIGNS})|ReplaceComparisonOperator_({COMPARISONS})|"
    "ReplaceUnaryOperator_(USub_UAdd|Delete_Not)|ReplaceAndWithOr|ReplaceOrWithAnd)$"
)
"""Of the changes of cosmic-ray those that turn physics into other physics, not into an error of types."""
NO_PRODUCTS = {"parameters", "param", "lambdef", "argument", "star_expr"}
"""Where `*` and `/` of the grammar are no operators: ``f(*x)``, ``def f(x, *, y)``."""
MESSAGES = {"msg", "allowed"}
"""Names of texts that say what is wrong; numbers there, and in what is raised, change no result."""
COSTS = {
    "_PADDING", "_ROWS", "TILE", "_WORTH_THREADS", "SMALL",  # how much at once
    "COARSE_LIMIT", "COARSE_ITERATIONS", "ITERATIONS", "HALVINGS", "VERIFICATIONS", "ATTEMPTS",  # how often at most
    "_BULK_STEPS", "_SURFACE_STEPS", "_SETTLING", "_SEED", "_MOST_PIECES", "_RELAXING", "PATIENCE", "_LOOK",
    "PIECES", "_KNOTS", "_NODES", "at_once",  # how finely
    "SMOOTH", "STIFF_SMOOTH", "COARSE_TOLERANCES", "COARSE_REDUCTION", "MISSED", "BEYOND", "SLOW", "LOOSE", "STALE",
    "CLOSE", "SNAPS", "NEWTON_STEPS", "TRIALS", "SLOPE_ACCEPTED", "SLOPE_REDUCTION", "BOX_TOLERANCE", "BOX_ITERATIONS",
    "SHORT_WAVES", "MOST_SMOOTH", "SMALL_SHARE", "MARGIN",  # by which way a solve goes to its tolerance
}  # fmt: skip
"""Constants of which one more or less costs time or memory, but gives the same result to its stated error."""
MANY = 100
"""Points of a `linspace`, and steps that a `limit` allows, of which one more or less is no other physics."""
SECONDS = 300
"""Time of one test, after which the change counts as caught: it does not end.  The slowest takes some 20 s."""


@cache
def text(module: str) -> str:
    """A module as it is when the draw begins: whoever works on meanwhile changes no mutant."""
    return (ROOT / module).read_text()


@dataclass(frozen=True)
class Mutant:
    """One change: occurrence of an operator in a module."""

    module: str
    operator: str
    occurrence: int

    def source(self) -> str:
        """The module with the change."""
        changed = mutate_code(text(self.module), get_operator(self.operator)(), self.occurrence)
        assert isinstance(changed, str)
        return changed

    def is_another_program(self) -> bool:
        """Whether Python reads it as other than it was."""
        return ast.dump(ast.parse(text(self.module))) != ast.dump(ast.parse(self.source()))

    def __str__(self) -> str:
        before, after = (text(self.module).splitlines(), self.source().splitlines())
        lines = [line for line in unified_diff(before, after, n=0, lineterm="") if line[:2] not in ("--", "++")]
        return "\n".join([f"{self.module} {lines[0]}", *lines[1:]])


def mutants() -> Iterator[Mutant]:
    """Every change in the rooms."""
    operators = [name for name in operator_names() if CHANGES.match(name)]
    for room in ROOMS:
        for path in sorted((ROOT / room).rglob("*.py")):
            module = path.relative_to(ROOT).as_posix()
            nodes = list(ast_nodes(get_ast(text(module))))
            for name in operators:
                operator = get_operator(name)()
                # One place after the other, as they are counted where a change is made.
                places = (node for node in nodes for _ in operator.mutation_positions(node))
                yield from (Mutant(module, name, i) for i, node in enumerate(places) if is_physics(node))


def is_physics(node: Any) -> bool:
    """Whether a result may hang on a node: it is no mark of the grammar, and neither in a message nor a mere cost."""
    if getattr(node, "value", "") in ("*", "/", "**") and node.parent.type in NO_PRODUCTS:
        return False
    many = node.type == "number" and node.value.isdigit() and int(node.value) >= MANY
    while node.parent is not None:
        if many and node.get_code().strip().startswith(("limit=", "np.linspace(")):
            return False
        if node.get_code().strip().startswith("np.empty("):  # room for what is written there: more of it is not used
            return False
        if node.type == "raise_stmt":
            return False
        if node.type == "expr_stmt":
            names = set(re.findall(r"\w+", node.get_code().partition("=")[0]))
            if names & (MESSAGES | COSTS):
                return False
        node = node.parent
    return True


def draw(every: list[Mutant], count: int, seed: int) -> list[Mutant]:
    """So many changes at random, but for those that Python reads as the same, such as 1e30 + 1."""
    order = random.Random(seed).sample(every, len(every))
    return list(islice((mutant for mutant in order if mutant.is_another_program()), count))


@cache
def imported() -> dict[str, str]:
    """Each file of tests, and its text."""
    found = sorted((ROOT / "tests").rglob("test_*.py"))
    return {path.relative_to(ROOT).as_posix(): path.read_text() for path in found}


def nearest_tests(module: str) -> list[list[str]]:
    """The files of tests that a module has, the nearest first: of its own name, that import it, then of its room."""
    package, room, *_ = module.split("/")
    named = module.removesuffix(".py").replace("/", ".")
    above, _, stem = named.rpartition(".")
    # A name of the module, or the module itself, in a line or in parentheses.
    asks = re.compile(rf"^from (?:{named} import|{above} import (?:\([^)]*|[^\n(]*)\b{stem}\b)", re.MULTILINE)
    direct = [name for name, text in imported().items() if asks.search(text)]
    beside = [name for name in imported() if name.startswith(f"tests/{package}/{room}/")]
    own = [name for name in beside if Path(name).stem == f"test_{Path(module).stem}"]
    here = [name for name in direct if name in beside]
    groups, seen = list[list[str]](), set[str]()
    for group in (own, here, [*direct, *beside]):
        new = [name for name in dict.fromkeys(group) if name not in seen]
        seen.update(new)
        groups += [new] if new else []
    return groups


def copied(folder: Path) -> Path:
    """A copy of the checkout, in which modules can be changed."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    for name in listed:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / name, folder / name)
    return folder


def run_tests(copy: Path, tests: list[str], compiled: Path | None) -> subprocess.CompletedProcess[str]:
    """Tests of a copy until the first that fails; compiled loops are kept in a folder of their own if one is given."""
    given = os.environ | {"PYTHONPATH": str(copy)}
    if compiled:
        # A loop beyond the end of its part of a row reads the right numbers, unless that is asked about.
        given |= {"NUMBA_CACHE_DIR": str(compiled), "NUMBA_BOUNDSCHECK": "1"}
    options = ["-x", "-q", "-rfE", "--tb=no", "-p", "no:cacheprovider"]
    # The limit is one for each test, as all tests near a change of `grid` take minutes on a busy machine.
    options += ["-o", f"faulthandler_timeout={SECONDS}", "-o", "faulthandler_exit_on_timeout=true"]
    return subprocess.run(
        [sys.executable, "-m", "pytest", *options, *tests],
        cwd=copy, env=given, capture_output=True, text=True, check=False,
    )  # fmt: skip


def first_failure(mutant: Mutant, copy: Path) -> str:
    """The test that fails first after a change, empty where all near it pass."""
    module = copy / mutant.module
    before = text(mutant.module)
    module.write_text(mutant.source())
    try:
        with tempfile.TemporaryDirectory() as compiled:
            # Kernels that others call are part of those: what is compiled is not kept from one change to the next.
            for tests in nearest_tests(mutant.module):  # most changes are seen by the first, at the cost of these alone
                done = run_tests(copy, tests, Path(compiled) if "njit" in before else None)
                if done.returncode not in (0, 5):  # 5: all of its tests are long ones
                    break
            else:
                return ""
    finally:
        module.write_text(before)
    failed = re.search(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", done.stdout, re.MULTILINE)
    if not failed and done.returncode not in (1, 2) and done.returncode > 0:
        raise RuntimeError(f"pytest could not run: {done.stdout}{done.stderr}")
    return failed[1] if failed else f"a test that does not end within {SECONDS} s"


@cache
def passes_unchanged(test: str, copy: Path) -> bool:
    """Whether a test passes in a copy without a change; if not it says nothing of a change."""
    return run_tests(copy, [test.partition("[")[0]], None).returncode == 0


def main() -> int:
    """Draw, change, test; the exit code is 1 if fewer than 95 of 100 are caught."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100, help="changes to draw (default: 100)")
    parser.add_argument("--seed", type=int, default=0, help="of the draw (default: 0)")
    parser.add_argument("--workers", type=int, default=2, help="changes at once (default: 2)")
    given = parser.parse_args()
    every = list(mutants())
    drawn = draw(every, given.count, given.seed)
    print(f"{len(drawn)} of {len(every)} changes", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        copies: SimpleQueue[Path] = SimpleQueue()
        for i in range(given.workers):
            copies.put(copied(Path(folder) / str(i)))
        imported()

        def tested(mutant: Mutant) -> bool:
            copy = copies.get()
            try:
                failure = first_failure(mutant, copy)
                if "::" in failure and not passes_unchanged(failure, copy):
                    raise RuntimeError(f"{failure} fails without a change as well")
            finally:
                copies.put(copy)
            print(f"{f'caught by {failure}' if failure else 'SURVIVES'}\n{mutant}\n", flush=True)
            return not failure

        with ThreadPoolExecutor(given.workers) as pool:
            alive = sum(pool.map(tested, drawn))
    print(f"{len(drawn) - alive} of {len(drawn)} are caught")
    return 0 if alive <= 0.05 * len(drawn) else 1


if __name__ == "__main__":
    raise SystemExit(main())
