"""Commands made from functions: their options, defaults and help are those of the function that does the work.

What this module imports is light, so that ``--help`` comes at once.
"""

import atexit
import gc
import inspect
import os
import re
import signal
import sys
from collections import OrderedDict
from collections.abc import Callable, Container, Mapping, Sequence
from functools import partial, wraps
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from cyclopts import App, CycloptsError, Parameter, convert
from cyclopts.validators import Number

from continuum.inputs.errors import BAD_INPUT, EXIT_CODES, OK, InputError
from continuum.model import caches

Command = Callable[..., int]
SEVERAL = inspect.Parameter.VAR_POSITIONAL
VOICES = {
    "quiet": Parameter(name=("--quiet", "-q"), show_default=False, help="print results, warnings and errors only, "
                       "without progress and tables"),
    "verbose": Parameter(name=("--verbose", "-v"), show_default=False, help="print a line for each part of the work, "
                         "also on a terminal, and where in the program an error arose"),
}  # fmt: skip
Format = Literal["png", "pdf", "svg"]
FIGURES = "format of the figures; may be repeated (default: png and pdf)"
"""Help of ``--format``."""


def _set(_: type, tokens: Sequence[Any]) -> list[tuple[str, object]]:
    from continuum.inputs.toml import value_of

    found = []
    for token in tokens:
        key, equals, value = token.value.partition("=")
        if not equals or not key.strip():
            raise ValueError(f"{token.value!r}: write KEY=VALUE, such as surface.seed=3")
        found.append((key.strip(), value_of(value.strip())))
    return found


def _shard(_: type, tokens: Sequence[Any]) -> tuple[int, int]:
    part, slash, parts = tokens[0].value.partition("/")
    if not (slash and part.isdecimal() and parts.isdecimal() and 1 <= int(part) <= int(parts)):
        raise ValueError(f"{tokens[0].value!r}: write I/N with I from 1 to N, such as 2/8")
    return int(part), int(parts)


def _whole(_: type, tokens: Sequence[Any]) -> int:
    """A whole number; cyclopts itself would round 1.9."""
    try:
        return int(tokens[0].value)
    except ValueError:
        raise ValueError(f"{tokens[0].value!r}: write a whole number, such as 2") from None


def _gigabytes(_: type, tokens: Sequence[Any]) -> float:
    return 1e9 * float(convert(float, tokens))


_COUNT = Number(gte=1, lte=1024)
OPTIONS: Mapping[str, Parameter] = {
    "output": Parameter(name=("--output", "-o")),
    "workers": Parameter(name=("--workers", "-j"), validator=Number(gte=0, lte=1024)),
    "threads": Parameter(validator=_COUNT),
    "nodes": Parameter(validator=_COUNT),
    "shards": Parameter(name="--array", validator=_COUNT),
    "settings": Parameter(name="--set", metavar="KEY=VALUE", converter=_set, n_tokens=1, accepts_keys=False, help=
                          "value for a key of the input, as surface.seed=3; may be repeated"),
    "shard": Parameter(metavar="I/N", converter=_shard, n_tokens=1, show_default=False,
                       help="part I/N of the systems, as 2/8 (default: 1/1, all)"),
    "memory": Parameter(converter=_gigabytes),
    "modules": Parameter(name="--module"),
    "lines": Parameter(name="--line"),
    "creators": Parameter(name="--creator"),
    "contact_modulus": Parameter(name="--estar"),
    "decks": Parameter(name="--keep-decks"),
    "browser": Parameter(negative="--no-browser"),
    "solve": Parameter(negative="--no-solve"),
}  # fmt: skip
"""Options of arguments by name, where a command line needs more than type and description."""


def program(
    name: str, what: str, units: str, commands: Mapping[str, str], module: str, apart: Mapping[str, str]
) -> App:
    """A program with commands, each with its help; the one called is imported from a module, or from one apart."""

    def versions() -> str:
        from continuum.store.provenance import versions

        return versions()

    codes = "Exit codes: " + "; ".join(f"{code} {meaning}" for code, meaning in EXIT_CODES.items()) + "."
    app = App(
        name=name, help=what, help_epilogue=f"Units: {units}.  {codes}", help_format="plaintext", version=versions,
        default_parameter=Parameter(negative=""), result_action="return_value", help_flags=["--help", "-h"],
    )  # fmt: skip

    @app.command(help="print the completion script for your shell: bash, zsh or fish")
    def completion(
        shell: Annotated[Literal["bash", "zsh", "fish"], Parameter(help="shell that is to complete commands")], /
    ) -> int:
        print(app.generate_completion(prog_name=name, shell=shell))
        return OK

    for command, text in commands.items():
        app.command(f"{name}.{apart.get(command, module)}:{command}", name=command, help=text)
    return app


def run_program(app: App, arguments: Sequence[str] | None) -> int:
    """Run a command of a program; returns its exit code."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    if arguments is None:  # started as a program, whose end need not look for cycles: half a second after numba
        atexit.register(gc.freeze)
    while words and any(words[0] in (voice.name or ()) for voice in VOICES.values()):  # they may stand anywhere
        words.append(words.pop(0))
    words = _with_lone_dashes(words)
    try:
        _check_environment()
        if not {"--help", "-h", "--version", "doctor", "completion"} & set(words):
            from continuum.front.installed import refuse_others

            refuse_others()
        done = app(words, exit_on_error=False, print_error=False)
    except CycloptsError as error:
        text = re.sub(r"(?<!\.)\.$", "", str(error))  # without its full stop
        sys.stderr.write(f"{app.name[0]}: {text}; see `{app.name[0]} --help`\n")
        raise SystemExit(BAD_INPUT) from None
    except InputError as error:
        sys.stderr.write(f"{error}\n")
        return error.exit_code
    except KeyboardInterrupt:
        sys.stderr.write("stopped; nothing was done\n")
        return 128 + signal.SIGINT
    if done is None and not {"--help", "-h", "--version"} & set(words):  # no command: the help was printed
        raise SystemExit(BAD_INPUT)
    return int(done or OK)


def _with_lone_dashes(words: Sequence[str]) -> list[str]:
    """The words of a command, with ``--size -`` as ``--size=-``: a dash alone is a value, not an option."""
    found: list[str] = []
    for word in words:
        if word == "-" and found and found[-1].startswith("--") and "=" not in found[-1]:
            found[-1] += "=-"
        else:
            found.append(word)
    return found


def _check_environment() -> None:
    """Check the environment variables on which a library would end in a traceback when it is imported; set BLAS' own.

    matplotlib does so if MPLBACKEND names an unknown back end, or the user's matplotlibrc cannot be read; commands draw
    into files, in a style of their own, so that both are left out.  Without a home it would write its list of fonts
    again in each process, and say so.

    Raises InputError that names the variable if a number of threads is not one, or a matplotlibrc of this folder, which
    nothing overrules, if it cannot be read.
    """
    os.environ |= {"MPLBACKEND": "agg", "MATPLOTLIBRC": os.devnull}
    # Matrices are small here: threads of BLAS would only wait for one another, a second for the moduli of crystals.
    for name in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    if "MPLCONFIGDIR" not in os.environ and not caches.at_home() and (folder := caches.folder_for("matplotlib")):
        os.environ["MPLCONFIGDIR"] = str(folder)
    here = Path("matplotlibrc")
    try:
        here.is_file() and here.read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        msg = f"{here.absolute()}: matplotlib reads this file, and cannot ({error}): save it as UTF-8, or move it"
        raise InputError(msg) from error
    for name, least in (("NUMBA_NUM_THREADS", 1), ("OMP_NUM_THREADS", 0), ("DUCC0_NUM_THREADS", 0)):
        value = os.environ.get(name)
        if value is not None and not (value.isdecimal() and int(value) >= least):
            msg = f"{name} = {value!r}, in the environment: allowed: a whole number of at least {least}; or unset it"
            raise InputError(msg)


def as_options(message: str, known: Container[str]) -> str:
    """Replace arguments in backticks by the options of a command in a message."""

    def option(found: re.Match[str]) -> str:
        given = OPTIONS.get(found[1], Parameter()).name or [f"--{found[1].replace('_', '-')}"]
        return next(iter(given)) if found[1] in known else found[0]

    return re.sub(r"`(\w+)`", option, message)


def like(
    function: Callable[..., object],
    help: Mapping[str, str] | None = None,
    draws: str = "",
    *,
    resumes: bool = False,
) -> Callable[[Command], Command]:
    """Make a command of a function: it takes the arguments of ``function``, and those that it names itself.

    An argument that the command names keeps its type and default; the others arrive in ``**given``, if they were given.
    Functions, mappings and the like do not become options.  Help texts come from the docstring of ``function``.

    Parameters
    ----------
    function : a function with a docstring in NumPy's style.
    help : help texts of arguments that are described elsewhere, or otherwise than in Python.
    draws : help of ``--format``, of a command that draws figures.
    resumes : whether the command, once stopped, continues from what it stored.
    """

    def made(command: Command) -> Command:
        signature = _signature(function, command, arguments_of(function) | dict(help or {}), draws)
        own = inspect.signature(command)

        @wraps(command)
        def called(*args: Any, **given: Any) -> int:
            from continuum.show.console import Voice, exit_code

            arguments = signature.bind(*args, **given).arguments
            arguments |= {name: dict(pairs) for name, pairs in arguments.items() if name == "settings"}
            voice: Voice = "normal"
            for name in get_args(Voice):
                voice = name if arguments.pop(name, False) else voice
            formats = arguments.pop("format", None) if draws else None
            mine = {name: arguments.pop(name) for name in own.parameters if name in arguments}
            bound = inspect.BoundArguments(own, OrderedDict(mine, given=arguments))
            ready: Callable[[], int] = partial(command, *bound.args, **bound.kwargs)
            if formats:
                from continuum.show.plot import written_as

                ready = written_as(formats)(ready)
            known = [name for name, one in signature.parameters.items() if one.kind is one.KEYWORD_ONLY]
            return exit_code(ready, voice, partial(as_options, known=known), resumes=resumes)

        vars(called)["__signature__"] = signature
        called.__doc__ = command.__doc__ or inspect.cleandoc(function.__doc__ or "").partition("\n\nParameters")[0]
        called.__annotations__ = {name: parameter.annotation for name, parameter in signature.parameters.items()}
        return called

    return made


def _signature(
    function: Callable[..., object], command: Command, texts: Mapping[str, str], draws: str
) -> inspect.Signature:
    own, hints = inspect.signature(command).parameters, get_type_hints(command, include_extras=True)
    types = {name: _option(name, of) for name, of in get_type_hints(function).items()} | hints
    others = inspect.signature(function).parameters if "given" in own else {}
    found = list[inspect.Parameter]()
    for name, parameter in {**others, **own}.items():
        if (of := types[name]) is None or parameter.kind is parameter.VAR_KEYWORD:
            continue
        kind = parameter.kind
        if kind is not SEVERAL:
            kind = parameter.POSITIONAL_ONLY if parameter.default is parameter.empty else parameter.KEYWORD_ONLY
        shown = None if parameter.default and not isinstance(parameter.default, tuple) else False
        said = [Parameter(help=texts.get(name), show_default=shown), *filter(None, [OPTIONS.get(name)])]
        if int in (get_args(of) or (of,)):
            said.insert(0, Parameter(converter=_whole))
        # What the command itself says of it comes last, and counts.
        annotation: Any = Annotated[(of, *said, *getattr(of, "__metadata__", ()))]
        found.append(parameter.replace(annotation=annotation, kind=kind))
    extra: list[tuple[str, object, Any]] = [(name, False, Annotated[bool, flag]) for name, flag in VOICES.items()]
    if draws:
        formats = Annotated[list[Format] | None, Parameter(help=draws)]
        extra.insert(0, ("format", None, formats))
    for name, default, of in extra:
        found.append(inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=of))
    return inspect.Signature(sorted(found, key=lambda parameter: parameter.kind))


def _option(name: str, annotation: Any) -> Any:
    """Type of an option for an argument of this name and type; None if it cannot be an option."""
    if name == "settings":
        return list[tuple[str, object]] | None
    types = get_args(annotation) if get_origin(annotation) in (Union, UnionType) else (annotation,)
    several = [one for one in types if get_origin(one) in (list, Sequence)]
    lists = [list[float] if float in get_args(one) else list[str] for one in several]
    known = [one for one in (Path, bool, int) if one in types] + lists + [one for one in (str, float) if one in types]
    found = next(iter([*known, *(one for one in types if get_origin(one) in (Literal, tuple))]), None)
    return found | None if found is not None and (type(None) in types or found in lists) else found


def arguments_of(function: Callable[..., object]) -> dict[str, str]:
    """The descriptions of the arguments in the docstring of a function, as plain text, but for what only Python has."""
    text = inspect.cleandoc(function.__doc__ or "").partition("\nParameters\n----------\n")[2].partition("\n\n")[0]
    found = dict[str, str]()
    for names, said in re.findall(r"^(\w[\w, ]*) : (.*(?:\n .*)*)", text, re.MULTILINE):
        of_command = " ".join(said.split()).partition("; in Python ")[0]
        plain = re.sub(r":\w+:`[\w.]*?(\w+)`|``", r"\1", of_command)
        found |= dict.fromkeys(names.split(", "), plain)
    return found
