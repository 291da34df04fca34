"""Mutation tests: one change at a time in the physics, and whether any test near it fails.

``make mutants`` draws a hundred changes at random, and asks the tests nearest to each first.  A change that no
test sees is a test that is missing, a line that nobody needs, or one that means the same: the list at the end says
which they are.
"""

from __future__ import annotations

import argparse
import ast
import gc
import inspect
import multiprocessing
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from difflib import unified_diff
from functools import cache
from itertools import islice
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any

import pytest
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
NO_PRODUCTS = {"parameters", "param", "lambdef", "argument", "star_expr", "dictorsetmaker", "atom"}
"""Where `*` and `/` of the grammar are no operators: ``f(*x)``, ``def f(x, *, y)``, ``{**x}``."""
MESSAGES = {"msg", "allowed", "VERSION", "example"}
"""Names of texts that say what is wrong, of formats of files and of examples of an input; numbers there, and in what is
raised, change no result."""
COSTS = {
    "_PADDING", "_ROWS", "TILE", "_WORTH_THREADS", "SMALL", "_FIELDS",  # how much at once
    "COARSE_LIMIT", "COARSE_ITERATIONS", "ITERATIONS", "HALVINGS", "VERIFICATIONS", "ATTEMPTS", "NEWTON",
    # how often at most
    "_BULK_STEPS", "_SURFACE_STEPS", "_SETTLING", "_SEED", "_OTHER_SEED", "_MOST_PIECES", "_RELAXING", "PATIENCE",
    "_LOOK", "PIECES", "_KNOTS", "_NODES", "_DIRECTIONS", "at_once",  # how finely
    "SMOOTH", "STIFF_SMOOTH", "COARSE_TOLERANCES", "COARSE_REDUCTION", "MISSED", "BEYOND", "SLOW", "LOOSE", "STALE",
    "CLOSE", "SNAPS", "NEWTON_STEPS", "TRIALS", "SLOPE_ACCEPTED", "SLOPE_REDUCTION", "BOX_TOLERANCE", "BOX_ITERATIONS",
    "SHORT_WAVES", "MOST_SMOOTH", "SMALL_SHARE", "MARGIN", "FEWEST", "LEAST", "SMALLEST", "LEVELS",
    "SPACING", "FARTHER",
    # by which way a solve goes to its tolerance
    "THICK", "OPAQUE", "FAR",  # from where on another formula gives the same digits
    "guess", "volumes",  # about where a crystal is looked for, which is there or an error is raised
}  # fmt: skip
"""Constants of which one more or less costs time or memory, but gives the same result to its stated error."""
MANY = 10
"""Points of a `linspace` or `geomspace`, `parts` of an integral, and steps of a `limit` or `evaluations` at most, of
which one more or less is no other physics."""
SECONDS = 120
"""CPU time of one test, after which the change counts as caught: it does not end.  The slowest takes some 20 s."""
LIBRARIES = ["numba", "numpy", "scipy.optimize", "scipy.ndimage", "scipy.signal", "scipy.stats", "pydantic", "pandas",
             "xarray", "matplotlib.pyplot", "pytest", "ase.build"]  # fmt: skip
"""Imported once, before the changes; hypothesis is imported by pytest, which looks at its assertions."""
KERNELS = re.compile(r"^@(compiled|inlined|kept_on_disk|njit)\b", re.MULTILINE)
"""What says that a module has compiled loops."""


Functions = dict[tuple[str, int], CodeType]
"""Code of functions, by name and line."""


def place_of(code: CodeType) -> tuple[str, int]:
    """Name and line of a function."""
    return code.co_qualname, code.co_firstlineno


def functions_in(code: CodeType) -> Functions:
    """All functions that a piece of code defines."""
    within = [one for one in code.co_consts if isinstance(one, CodeType)]
    own = {place_of(one): one for one in within if one.co_flags & inspect.CO_OPTIMIZED}
    return own | {key: one for each in within for key, one in functions_in(each).items()}


def outside_functions(code: CodeType) -> list[Any]:
    """What a module does when it is imported, but for what its functions do."""
    within = [one for one in code.co_consts if isinstance(one, CodeType) and not one.co_flags & inspect.CO_OPTIMIZED]
    constants = [repr(one) for one in code.co_consts if not isinstance(one, CodeType)]
    return [code.co_code, code.co_names, constants, *(outside_functions(one) for one in within)]


@dataclass(frozen=True)
class Mutant:
    """One change: occurrence of an operator in a module."""

    module: str
    text: str
    """As it is when the draw begins: whoever works on meanwhile changes no mutant."""
    operator: str
    occurrence: int

    def source(self) -> str:
        """The module with the change."""
        changed = mutate_code(self.text, get_operator(self.operator)(), self.occurrence)
        assert isinstance(changed, str)
        return changed

    def is_compiled(self) -> bool:
        """Whether loops have to be compiled anew."""
        return bool(KERNELS.search(self.text))

    @cache  # noqa: B019 (a draw has a hundred)
    def functions(self) -> Functions:
        """New code of the functions that a change within functions alters; empty for any other change."""
        before, after = (compile(one, self.module, "exec") for one in (self.text, self.source()))
        if self.is_compiled() or outside_functions(before) != outside_functions(after):
            return {}
        old = functions_in(before)
        return {key: code for key, code in functions_in(after).items() if code != old.get(key)}

    def make(self, copy: Path) -> None:
        """Change the file of a copy."""
        (copy / self.module).rename(copy / "unchanged")
        (copy / self.module).write_text(self.source())

    def take_back(self, copy: Path) -> None:
        """Undo :meth:`make`; compiled code of the file holds again."""
        (copy / "unchanged").replace(copy / self.module)

    def make_here(self, copy: Path) -> None:
        """Change the functions that this process has imported from a copy; if there are none it imports the change."""
        gc.unfreeze()
        of_module = [each for each in gc.get_objects() if isinstance(each, FunctionType)]
        of_module = [each for each in of_module if each.__code__.co_filename == str(copy / self.module)]
        found = [each for each in of_module if place_of(each.__code__) in self.functions()]
        assert bool(found) == bool(of_module), "a change of no function"
        for each in found:
            each.__code__ = self.functions()[place_of(each.__code__)]

    def is_another_program(self) -> bool:
        """Whether Python reads it as other than it was."""
        return ast.dump(ast.parse(self.text)) != ast.dump(ast.parse(self.source()))

    def __str__(self) -> str:
        before, after = (self.text.splitlines(), self.source().splitlines())
        lines = [line for line in unified_diff(before, after, n=0, lineterm="") if line[:2] not in ("--", "++")]
        return "\n".join([f"{self.module} {lines[0]}", *lines[1:]])


def mutants() -> Iterator[Mutant]:
    """Every change in the rooms."""
    operators = [name for name in operator_names() if CHANGES.match(name)]
    for room in ROOMS:
        for path in sorted((ROOT / room).rglob("*.py")):
            module = path.relative_to(ROOT).as_posix()
            text = path.read_text()
            nodes = list(ast_nodes(get_ast(text)))
            for name in operators:
                operator = get_operator(name)()
                # One place after the other, as they are counted where a change is made.
                places = (node for node in nodes for _ in operator.mutation_positions(node))
                yield from (Mutant(module, text, name, i) for i, node in enumerate(places) if is_physics(node))


def is_physics(node: Any) -> bool:
    """Whether a result may hang on a node: it is no mark of the grammar, and neither in a message nor a mere cost."""
    if getattr(node, "value", "") in ("*", "/", "**") and node.parent.type in NO_PRODUCTS:
        return False
    last = node.value if node.type == "number" else None
    before = getattr(node.get_previous_sibling(), "value", "")
    many = node.type == "number" and node.value.isdigit() and int(node.value) >= MANY
    while node.parent is not None:
        # The code of a whole module is not asked for at each of its numbers.
        call = node.get_code().strip() if node.type in ("atom_expr", "argument", "param", "expr_stmt") else ""
        if many and call.startswith(("limit=", "parts", "evaluations:", "np.linspace(", "np.geomspace(")):
            return False
        # How a file is laid out, which reads the same.
        if call.startswith("indent="):
            return False
        # A length that is left to be found: -2 says the same as -1, and 0 fails at once.
        if last == "1" and before == "-" and re.search(r"reshape\([^)]*-1", call):
            return False
        # Room, of which more is not used and less fails at once; and a seed of where a search begins.
        if re.match(r"([\w.]+\.)?(empty|zeros|default_rng)\(", call):
            return False
        # What is divided by where the quotient is not taken.
        if re.match(r"([\w.]+\.)?where\(", call) and call.endswith(f", {last})") and is_divisor(node):
            return False
        if node.type == "raise_stmt":
            return False
        if node.type == "expr_stmt":
            names = set(re.findall(r"\w+", node.get_code(include_prefix=False).partition("=")[0]))
            if names & (MESSAGES | COSTS):
                return False
        node = node.parent
    return True


def is_divisor(node: Any) -> bool:
    """Whether something is divided by a node."""
    before = node.get_previous_sibling()
    return before is not None and getattr(before, "value", "") == "/"


def draw(every: list[Mutant], count: int, seed: int) -> list[Mutant]:
    """So many changes at random, but for those that Python reads as the same, such as 1e30 + 1."""
    order = random.Random(seed).sample(every, len(every))
    return list(islice((mutant for mutant in order if mutant.is_another_program()), count))


@cache
def imported(root: Path) -> dict[str, str]:
    """Each file of tests, and its text."""
    found = sorted((root / "tests").rglob("test_*.py"))
    return {path.relative_to(root).as_posix(): path.read_text() for path in found}


@cache
def nearest_tests(module: str, root: Path = ROOT) -> list[list[str]]:
    """The files of tests that a module has, the nearest first: of its own name, in its room, that import it elsewhere.

    Of those in its room the ones that import it come first.
    """
    files = imported(root)
    package, room, *_ = module.split("/")
    named = module.removesuffix(".py").replace("/", ".")
    above, _, stem = named.rpartition(".")
    # A name of the module, or the module itself, in a line or in parentheses.
    asks = re.compile(rf"^from (?:{named} import|{above} import (?:\([^)]*|[^\n(]*)\b{stem}\b)", re.MULTILINE)
    direct = [name for name, text in files.items() if asks.search(text)]
    beside = [name for name in files if f"/{package}/{room}/" in name]
    own = [name for name in beside if Path(name).stem == f"test_{Path(module).stem}"]
    here = [name for name in direct if name in beside]
    groups, seen = list[list[str]](), set[str]()
    for group in (own, here, beside, direct):
        new = [name for name in group if name not in seen]
        seen.update(new)
        groups += [new] if new else []
    return groups


def copied(folder: Path) -> Path:
    """A copy of the checkout, in which modules can be changed, with what is compiled of it already."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    kept = (
        path.relative_to(ROOT) for room in ("continuum", "atomistic") for path in (ROOT / room).rglob("__pycache__/*")
    )
    for name in (*listed, *kept):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, folder / name)
    return folder


@dataclass(eq=False)
class Tests:
    """A run of tests in a copy, the plugin of pytest that chooses them and notes which fail.

    Parameters
    ----------
    files : in the order of the run.
    only : tests that are run, all of the files if empty; of one whose parameters are no longer there, all parameters.
    but : tests that are not run.
    changes : for each of which these tests are run, until the first that fails, with the files that it asks.
    """

    files: list[str]
    only: frozenset[str] = frozenset()
    but: frozenset[str] = frozenset()
    changes: tuple[tuple[int, Mutant, list[str]], ...] = ()
    out: int = 1
    """Where answers are printed."""

    @pytest.hookimpl(trylast=True)
    def pytest_configure(self) -> None:
        """That a property fails is enough: its smallest example would take a minute."""
        from hypothesis import Phase, settings

        phases = (Phase.explicit, Phase.reuse, Phase.generate)
        settings.register_profile("first failure", settings(), phases=phases)
        settings.load_profile("first failure")

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Choose and order."""
        known = {item.nodeid for item in items}
        only = {name if name in known else name.partition("[")[0] for name in self.only}
        chosen = [item for item in items if not only or {item.nodeid, item.nodeid.partition("[")[0]} & only]
        items[:] = in_order([item for item in chosen if item.nodeid not in self.but], self.files)

    def pytest_runtest_logreport(self, report: pytest.TestReport | pytest.CollectReport) -> None:
        """Note what fails."""
        if report.failed:
            with Path("failed").open("a") as file:
                print(report.nodeid, file=file)

    pytest_collectreport = pytest_runtest_logreport

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self) -> None:
        """The limit is one of CPU time, and for each test: a busy machine takes an hour for all tests near `grid`."""
        signal.setitimer(signal.ITIMER_PROF, SECONDS)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool | None:
        """Make each change in a fork, which goes on as usual; as a run does that has none."""
        copy, catches = Path.cwd(), Counter[str]()
        for number, mutant, files in self.changes:
            (copy / "failed").write_text("")
            files.sort(key=lambda name: -catches[name])  # what has caught most changes is likely to catch the next
            mutant.make(copy)
            child = os.fork()
            if child == 0:
                mutant.make_here(copy)
                session.items = in_order(session.items, files)
                return None
            code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
            mutant.take_back(copy)
            failure = next(iter(failed_in(copy, code)), "")
            catches[failure.partition("::")[0]] += 1
            self.say(copy, number, mutant, files, failure)
        return bool(self.changes) or None

    def say(self, copy: Path, number: int, mutant: Mutant, files: list[str], failure: str) -> None:
        """Print the answer of one change, and keep it."""
        with (copy / "answers").open("a") as file:
            print(number, failure, file=file)
        said = f"caught by {failure}" if failure else f"not seen by {', '.join(files)}"
        os.write(self.out, f"{number + 1}: {said}\n{mutant}\n\n".encode())

    def run(self, compiled: Path | None) -> None:
        """In a process of its own, in a copy: the exit status is that of pytest."""
        self.out = os.dup(1)
        with Path("output").open("w") as out:
            os.dup2(out.fileno(), 1)
            os.dup2(out.fileno(), 2)
        sys.path[:] = [str(Path.cwd()), *(path for path in sys.path if path and Path(path) != ROOT)]
        os.environ["PYTHONPATH"] = str(Path.cwd())
        for name in [name for name in sys.modules if name.partition(".")[0] == "tests"]:
            del sys.modules[name]
        if compiled:
            import numba

            # A loop beyond the end of its part of a row reads the right numbers, unless that is asked about.
            os.environ |= {"NUMBA_CACHE_DIR": str(compiled), "NUMBA_BOUNDSCHECK": "1"}
            numba.config.reload_config()
        options = ["-q", "--tb=short", "-p", "no:cacheprovider", *([] if self.only else ["-x"])]
        code = pytest.main([*options, *self.files], plugins=[self])
        sys.stdout.flush()
        os._exit(code)

    def failures(self, copy: Path, compiled: Path | None = None) -> list[str]:
        """The tests that fail in a copy; compiled loops are kept in a folder of their own if one is given."""
        (copy / "failed").write_text("")
        process = multiprocessing.get_context("forkserver").Process(target=in_copy, args=(copy, self, compiled))
        process.start()
        process.join()
        return failed_in(copy, process.exitcode or 0)


def in_order(items: list[pytest.Item], files: list[str]) -> list[pytest.Item]:
    """The tests of some files, in their order."""
    place = {name: i for i, name in enumerate(files)}
    chosen = [item for item in items if item.nodeid.partition("::")[0] in place]
    return sorted(chosen, key=lambda item: place[item.nodeid.partition("::")[0]])


def failed_in(copy: Path, code: int) -> list[str]:
    """The tests that have failed in a copy, by what is noted there and the exit status."""
    failed = (copy / "failed").read_text().split("\n")[:-1]
    if failed or code in (0, 5):  # 5: all of its tests are long ones
        return failed
    if code == -signal.SIGPROF:
        return [f"a test that does not end within {SECONDS} s"]
    if code < 0:
        return [f"an end of the process by signal {-code}"]
    raise RuntimeError(f"pytest could not run: {(copy / 'output').read_text()}")


def in_copy(copy: Path, tests: Tests, compiled: Path | None) -> None:
    """What a forked process does."""
    os.chdir(copy)
    tests.run(compiled)


def asked(
    copy: Path, changes: list[tuple[int, Mutant, list[str]]], but: frozenset[str], folder: Path
) -> dict[int, str]:
    """The test that fails first after each of some changes, empty where all pass, by their numbers."""
    (copy / "answers").write_text("")
    within = tuple(one for one in changes if one[1].functions())
    if within:
        Tests(sorted({name for *_, files in within for name in files}), but=but, changes=within).failures(copy)
        if len((copy / "answers").read_text().splitlines()) < len(within):
            raise RuntimeError(f"pytest ended before its time: {(copy / 'output').read_text()}")
    for number, mutant, files in (one for one in changes if not one[1].functions()):
        tests = Tests(files, but=but)
        mutant.make(copy)
        # Kernels that others call are part of those: what is compiled is not kept from one change to the next.
        failed = tests.failures(copy, folder / f"compiled{number}" if mutant.is_compiled() else None)
        mutant.take_back(copy)
        tests.say(copy, number, mutant, files, next(iter(failed), ""))
    answers = (line.partition(" ") for line in (copy / "answers").read_text().splitlines())
    return {int(number): failure for number, _, failure in answers}


def main() -> int:
    """Draw, change, test; the exit code is 1 if fewer than 95 of 100 are caught."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100, help="changes to draw (default: 100)")
    parser.add_argument("--seed", type=int, default=0, help="of the draw (default: 0)")
    parser.add_argument("--only", type=int, nargs="+", metavar="N", help="of those drawn, by number (default: all)")
    parser.add_argument("--workers", type=int, default=2, help="changes at once (default: 2)")
    given = parser.parse_args()
    multiprocessing.get_context("forkserver").set_forkserver_preload(LIBRARIES)
    every = list(mutants())
    drawn = dict(enumerate(draw(every, given.count, given.seed)))
    drawn = {number - 1: drawn[number - 1] for number in given.only or range(1, len(drawn) + 1)}
    print(f"{len(drawn)} of {len(every)} changes", flush=True)
    unsound, alive = set[str](), list(drawn)
    with tempfile.TemporaryDirectory() as made, ThreadPoolExecutor(given.workers) as pool:
        folder = Path(made).resolve()
        copies = [copied(folder / str(i)) for i in range(given.workers)]
        near = {number: nearest_tests(one.module, copies[0]) for number, one in drawn.items()}
        for away in range(max(map(len, near.values()))):
            todo = [number for number in alive if away < len(near[number])]
            while todo:
                changes = [(number, drawn[number], list(near[number][away])) for number in todo]
                parts = (pool.submit(asked, copy, changes[i :: given.workers], frozenset(unsound), folder)
                         for i, copy in enumerate(copies))  # fmt: skip
                failures = {number: failure for part in list(parts) for number, failure in part.result().items()}
                # A test that fails without a change as well says nothing of one.
                only = frozenset(failure for failure in failures.values() if "::" in failure)
                files = sorted({name.partition("::")[0] for name in only})
                wrong = set(Tests(files, only).failures(copies[0])) if only else set()
                print(*(f"fails without a change: {name}" for name in wrong), sep="\n", flush=True)
                unsound |= wrong
                caught = {number for number, failure in failures.items() if failure and failure not in wrong}
                alive = [number for number in alive if number not in caught]
                todo = [number for number in todo if failures[number] in wrong]
            print(f"{len(drawn) - len(alive)} of {len(drawn)} are caught by tests {away} away\n", flush=True)
    for number in alive:
        print(f"SURVIVES\n{number + 1}: {drawn[number]}\n")
    print(f"{len(drawn) - len(alive)} of {len(drawn)} are caught")
    return 0 if len(alive) <= 0.05 * len(drawn) else 1


if __name__ == "__main__":
    raise SystemExit(main())
