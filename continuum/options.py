"""Commands made from functions: their options, defaults and help are those of the function that does the work.

What this module imports is light, so that ``--help`` comes at once.
"""

import inspect
import os
import re
import signal
import sys
from collections.abc import Callable, Container, Mapping, Sequence
from functools import wraps
from pathlib import Path
from typing import Annotated, Any, Literal, get_args, get_origin, get_type_hints

from cyclopts import App, CycloptsError, Parameter
from cyclopts.validators import Number

from continuum.errors import BAD_INPUT, EXIT_CODES, OK, InputError

Format = Literal["png", "pdf", "svg"]
Formats = Annotated[
    list[Format] | None,
    Parameter(name="--format", help="format of the figures; may be repeated (default: png and pdf)"),
]
VOICES = {"quiet": ("-q", "print results, warnings and errors only, without progress and tables"),
          "verbose": ("-v", "print a line for each part of the work, also on a terminal, and where in the program an "
                      "error arose")}  # fmt: skip
SHORT = {"output": ("--output", "-o"), "workers": ("--workers", "-j")}
COUNTS = ("workers", "threads", "nodes", "shards")
POSITIONAL, SEVERAL = inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.VAR_POSITIONAL

Command = Callable[..., int]


def program(name: str, what: str, units: str, commands: Mapping[str, str], apart: Mapping[str, str]) -> App:
    """A program with commands, each with its help; the one called is imported from NAME.commands or a module apart."""

    def versions() -> str:
        from continuum.files.provenance import versions

        return versions()

    codes = "Exit codes: " + ".  ".join(f"{code}: {meaning}" for code, meaning in EXIT_CODES.items()) + "."
    app = App(
        name=name, help=what, help_epilogue=f"Units: {units}.  {codes}", help_format="plaintext", version=versions,
        default_parameter=Parameter(negative=""), result_action="return_value", help_flags=["--help", "-h"],
    )  # fmt: skip

    @app.command(help="print the completion script for your shell: bash, zsh or fish")
    def completion(shell: Literal["bash", "zsh", "fish"], /) -> int:
        print(app.generate_completion(prog_name=name, shell=shell))
        return OK

    for command, text in commands.items():
        app.command(f"{name}.{apart.get(command, 'commands')}:{command}", name=command, help=text)
    return app


def run_program(app: App, arguments: Sequence[str] | None, renamed: Mapping[str, str] | None = None) -> int:
    """Run a command of a program, by its name or by one of before that was renamed; returns its exit code."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    flags = {f"--{name}" for name in VOICES} | {short for short, _ in VOICES.values()}
    while words and words[0] in flags:  # they may stand anywhere
        words.append(words.pop(0))
    if words and (name := (renamed or {}).get(words[0])):
        sys.stderr.write(f"`{app.name[0]} {words[0]}` is now called `{app.name[0]} {name}`\n")
        words[0] = name
    words = _with_lone_dashes(words)
    try:
        _check_environment()
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
    """Check the environment variables on which a library would end in a traceback when it is imported.

    matplotlib does so if MPLBACKEND names an unknown back end; commands draw into files, so that it is overwritten.

    Raises InputError that names the variable if a number of threads is not one.
    """
    os.environ["MPLBACKEND"] = "agg"
    for name, least in (("NUMBA_NUM_THREADS", 1), ("OMP_NUM_THREADS", 0), ("DUCC0_NUM_THREADS", 0)):
        value = os.environ.get(name)
        if value is not None and not (value.isdecimal() and int(value) >= least):
            msg = f"{name} = {value!r}, in the environment: allowed: a whole number of at least {least}; or unset it"
            raise InputError(msg)


def as_options(message: str, known: Container[str]) -> str:
    """Replace arguments in backticks by the options of the command in a message."""

    def option(found: re.Match[str]) -> str:
        name = "estar" if found[1] == "contact_modulus" else found[1]
        return f"--{name.replace('_', '-')}" if found[1] in known else found[0]

    return re.sub(r"`(\w+)`", option, message)


def like(
    work: Callable[..., object], hint: str = "", help: Mapping[str, str] | None = None
) -> Callable[[Command], Command]:
    """Make a command of a function: it takes the arguments of ``work``, and those that it names itself.

    An argument that the command names keeps its type and default; the others arrive in ``**given``, if they were given.
    Functions, mappings and the like do not become options.  Help texts come from the docstring of ``work``.

    Parameters
    ----------
    work : a function with a docstring in NumPy's style.
    hint : text after the message of an unexpected error.
    help : help texts of arguments that are described elsewhere.
    """

    def made(command: Command) -> Command:
        signature = _signature(work, command, _help(work) | dict(help or {}))

        @wraps(command)
        def called(*args: Any, **given: Any) -> int:
            from continuum.show.console import Voice, exit_code

            arguments = signature.bind(*args, **given).arguments
            voice: Voice = "normal"
            for name in get_args(Voice):
                voice = name if arguments.pop(name, False) else voice
            own = {name: one.kind for name, one in inspect.signature(command).parameters.items()}
            one = [arguments.pop(name) for name, kind in own.items() if kind is POSITIONAL and name in arguments]
            several = [value for name, kind in own.items() if kind is SEVERAL for value in arguments.pop(name, ())]
            return exit_code(lambda: command(*one, *several, **arguments), hint, voice)

        vars(called)["__signature__"] = signature
        called.__doc__ = command.__doc__ or inspect.cleandoc(work.__doc__ or "").partition("\n\nParameters")[0]
        called.__annotations__ = {name: parameter.annotation for name, parameter in signature.parameters.items()}
        return called

    return made


def _signature(work: Callable[..., object], command: Command, texts: Mapping[str, str]) -> inspect.Signature:
    own, hints = inspect.signature(command).parameters, get_type_hints(command, include_extras=True)
    types = get_type_hints(work)
    others = any(parameter.kind is parameter.VAR_KEYWORD for parameter in own.values())
    parameters = {**(inspect.signature(work).parameters if others else {}), **own}
    found = dict[str, inspect.Parameter]()
    for name, parameter in parameters.items():
        taken = hints[name] if name in own else _option(types[name])
        if taken is None or parameter.kind is parameter.VAR_KEYWORD:
            continue
        needed = parameter.default is parameter.empty and parameter.kind is not SEVERAL
        kind = parameter.POSITIONAL_ONLY if needed else parameter.kind
        if kind is POSITIONAL:
            kind = parameter.KEYWORD_ONLY
        given, *said = get_args(taken) if get_origin(taken) is Annotated else (taken,)
        show_default = None if parameter.default else False
        bounds = Number(gte=1, lte=1024) if name in COUNTS else None
        described = Parameter(help=texts.get(name), name=SHORT.get(name), show_default=show_default, validator=bounds)
        found[name] = parameter.replace(annotation=_annotated(given, described, *said), kind=kind)
    for name, (letter, text) in VOICES.items():
        flag = Parameter(name=[f"--{name}", letter], help=text, show_default=False)
        keyword = inspect.Parameter.KEYWORD_ONLY
        found[name] = inspect.Parameter(name, keyword, default=False, annotation=_annotated(bool, flag))
    return inspect.Signature(sorted(found.values(), key=lambda parameter: parameter.kind))


def _annotated(given: Any, *said: Parameter) -> Any:
    return Annotated[(given, *said)]


def _option(annotation: Any) -> Any:
    """Type of an option for an argument of this type; None if it cannot be an option."""
    types = get_args(annotation) if get_origin(annotation) not in (None, Literal) else (annotation,)
    missing = None if type(None) in types else Literal
    for one in (Path, bool, int):
        if one in types:
            return one if missing else one | None
    if any(list[str] == one or getattr(get_origin(one), "__name__", "") == "Sequence" for one in types):
        return list[str] | None
    if str in types:
        return str if missing else str | None
    literal = next((one for one in types if get_origin(one) is Literal), None)
    return literal if missing or literal is None else literal | None


def _help(work: Callable[..., object]) -> dict[str, str]:
    """The descriptions of the arguments in the docstring of a function, as plain text, but for what only Python has."""
    text = inspect.cleandoc(work.__doc__ or "").partition("\nParameters\n----------\n")[2].partition("\n\n")[0]
    found = dict[str, str]()
    for names, said in re.findall(r"^(\w[\w, ]*) : (.*(?:\n .*)*)", text, re.MULTILINE):
        of_command = " ".join(said.split()).partition("; in Python ")[0]
        plain = re.sub(r":\w+:`[\w.]*?(\w+)`|``", r"\1", of_command)
        found |= dict.fromkeys(names.split(", "), plain)
    return found
