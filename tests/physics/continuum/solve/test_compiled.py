"""Compiled code on disk is never that of other formulas."""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import Any

from continuum.model import laws
from continuum.solve.compiled import compiling as compiled
from continuum.solve.compiled import near_field, points, pressing, spectra, tractions, two_levels

KERNELS: dict[str, Any] = {
    f"{module.__name__.split('.')[-1]}.{name}": kernel
    for module in (spectra, points, tractions, pressing, two_levels, near_field)
    for name, kernel in vars(module).items()
    if hasattr(kernel, "py_func") and kernel.py_func.__module__ == module.__name__ and kernel._cache is not None
    and "-" in kernel.py_func.__qualname__
}  # fmt: skip
"""Each compiled sweep."""


def test_there_are_sweeps() -> None:
    assert len(KERNELS) >= 50


def test_a_sweep_calls_compiled_code_of_its_own_file_and_of_the_named_sources_only() -> None:
    """numba's cache looks at its own file; the name of that in the cache has the digest of the others."""
    for name in KERNELS:
        kernel = KERNELS[name]
        file = kernel._cache._impl.filename_base
        assert file.split("-")[1].startswith(compiled.digest(compiled.SOURCES)), file
        seen, todo = set(), [kernel.py_func]
        while todo:
            function = todo.pop()
            for used in set(function.__code__.co_names) - seen:
                seen.add(used)
                value = function.__globals__.get(used)
                if hasattr(value, "py_func"):
                    source = Path(inspect.getfile(value.py_func))
                    assert source in (Path(inspect.getfile(kernel.py_func)), *compiled.SOURCES)
                    if source not in compiled.SOURCES:
                        todo.append(value.py_func)
                elif used == "TILE":
                    assert value == compiled.TILE
                elif f"\n{used} = " in inspect.getsource(inspect.getmodule(function)):
                    assert isinstance(value, int | float)  # of the file that numba looks at
                else:
                    assert value is None or inspect.ismodule(value), used


def test_types_that_a_sweep_is_given_stand_in_the_named_sources() -> None:
    """numba's index names them: one that is gone would end a solve where code of an older version is on disk."""
    types = {
        (value, Path(inspect.getfile(value)))
        for module in (spectra, points, tractions, pressing, two_levels, near_field)
        for value in vars(module).values()
        if isinstance(value, type) and issubclass(value, tuple)
    }
    assert len(types) >= 5
    assert {source for _, source in types} <= set(compiled.SOURCES)


def test_a_changed_formula_is_another_file_of_compiled_code(tmp_path: Path) -> None:
    changed = tmp_path / "laws.py"
    formulas = inspect.getsource(laws)
    assert "0.5 * below" in formulas
    changed.write_text(formulas.replace("0.5 * below", "0.25 * below"))
    rest = [source for source in compiled.SOURCES if source != Path(laws.__file__)]
    assert len(rest) == len(compiled.SOURCES) - 1
    assert compiled.digest([changed, *rest]) != compiled.digest(compiled.SOURCES)
    assert len(compiled.digest(rest)) == 12
