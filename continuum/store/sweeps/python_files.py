"""Definitions and imports of a Python file, found by parsing it: nothing is executed."""

import ast
import sys
import sysconfig
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from types import ModuleType
from typing import Any


def defined_names(body: Sequence[ast.stmt]) -> Iterator[tuple[str, bool]]:
    """Names that the statements of a module define, and whether each may be a function; "*" for all of another one."""
    for statement in body:
        match statement:
            case ast.FunctionDef(name) | ast.ClassDef(name):
                yield name, True
            case ast.Import(names) | ast.ImportFrom(names=names):
                yield from ((one.asname or one.name.partition(".")[0], True) for one in names)
            case ast.Assign(value=value) | ast.AnnAssign(value=value):
                targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
                function = not isinstance(value, ast.Constant | ast.List | ast.Tuple | ast.Dict | ast.Set | None)
                yield from ((one.id, function) for one in targets if isinstance(one, ast.Name))
            case ast.If() | ast.Try() | ast.With():
                yield from defined_names(statement.body)
                yield from defined_names(getattr(statement, "orelse", []))
                for handler in getattr(statement, "handlers", []):
                    yield from defined_names(handler.body)


def with_text_of(helpers: Iterable[Path]) -> str:
    """The text of files, each below its name."""
    found = ""
    for path in sorted({*helpers}):
        with suppress(OSError, ValueError):
            found += f"\n# --- {path.name}\n{path.read_text(encoding='utf-8')}"
    return found


def helpers_of(path: Path) -> Iterator[Path]:
    """Files beside a Python file that it imports, and that these import."""
    seen, left = {path.resolve()}, [path.resolve()]
    while left:
        with suppress(OSError, SyntaxError, ValueError, RecursionError, MemoryError):
            here = left.pop()
            for node in ast.walk(ast.parse(here.read_bytes())):
                for name in _imported(node):
                    module = here.parent.joinpath(*name.split("."))
                    for file in (module.with_name(f"{module.name}.py"), module / "__init__.py"):
                        if file.is_file() and file.resolve() not in seen:
                            seen.add(file.resolve())
                            left.append(file.resolve())
                            yield file.resolve()


def _imported(node: ast.AST) -> Iterator[str]:
    """Names of modules that a statement may import."""
    match node:
        case ast.Import(names):
            yield from (one.name for one in names)
        case ast.ImportFrom(module, names):
            yield from ([module] if module else [])
            yield from (f"{module}.{one.name}" if module else one.name for one in names)


def modules_used_by(function: Any) -> Iterator[Path]:
    """Files of modules, not of libraries, that a function uses by its global names, and those that these import."""
    code, known = getattr(function, "__code__", None), getattr(function, "__globals__", {})
    libraries = [Path(sysconfig.get_path(name)) for name in ("stdlib", "purelib", "platlib")]
    for name in getattr(code, "co_names", ()):
        used = known.get(name)
        module = used if isinstance(used, ModuleType) else sys.modules.get(getattr(used, "__module__", None) or "")
        file = Path(getattr(module, "__file__", None) or "")
        # A function of the script itself is sent with what it uses.
        ours = file.suffix == ".py" and getattr(module, "__name__", "") not in (
            "__main__",
            code and function.__module__,
        )
        if ours and not any(file.is_relative_to(library) for library in libraries):
            yield file.resolve()
            yield from helpers_of(file)
