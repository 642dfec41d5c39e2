"""The `hamr` command: finds the command's module, reads its arguments, prints its result; what goes wrong becomes one sentence.

A command is a module in commands/ whose docstring says what it does, with examples, and whose `Command` is a dataclass with
`run() -> dict` and, where a table does not do, `text(result) -> str`, or for commands in two words a dict from the second word to
such a dataclass. Standard output carries the result alone: a table, or with `--json` one JSON object, {"ok": false, "error": ...}
when it fails; progress and logs, also those of child processes, go to standard error. The exit status is 0 only on success.
"""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from types import ModuleType
from typing import TextIO

from hamr_description.errors import HamrError

from .environment import prepare
from .present import as_json_text, as_text

#: In the order of the help.
COMMANDS = ("demo", "up", "run", "collect", "train", "eval", "gap", "reproduce", "check", "bench", "bag", "render", "doctor")

FAILED, USAGE, INTERRUPTED = 1, 2, 130
AS_JSON = "--json"


def main() -> None:
    """Entry point of the console script."""
    prepare()
    sys.exit(run(sys.argv[1:]))


def run(argv: list[str]) -> int:
    """Run `hamr *argv` and return the exit status."""
    if not argv or argv[0] in ("-h", "--help"):
        (sys.stdout if argv else sys.stderr).write(overview())
        return 0 if argv else USAGE
    name, *rest = argv
    as_json = AS_JSON in rest
    if name not in COMMANDS:
        near = get_close_matches(name, COMMANDS, n=1)
        return _fail(f"there is no command '{name}'" + (f"; did you mean '{near[0]}'?" if near else "; hamr --help lists them."), USAGE)
    try:
        return _run(_module(name), name, [word for word in rest if word != AS_JSON], as_json=as_json)
    except HamrError as error:
        sentence, status = str(error), FAILED
    except OSError as error:
        sentence, status = f"{error.strerror or error}" + (f": '{error.filename}'." if error.filename else "."), FAILED
    except ModuleNotFoundError as error:
        if (error.name or "").startswith("hamr_"):
            raise
        sentence, status = f"the Python package '{error.name}' is not installed; hamr doctor says how to get it.", FAILED
    except KeyboardInterrupt:
        sentence, status = "interrupted.", INTERRUPTED
    if as_json:
        sys.stdout.write(as_json_text({"ok": False, "error": sentence}))
    return _fail(f"{name}: {sentence}", status)


def overview() -> str:
    """Help of `hamr` itself: one line a command."""
    lines = [f"  {name:9} {_module(name).__doc__.splitlines()[0]}" for name in COMMANDS]
    return "\n".join(["usage: hamr COMMAND [--json] ...", "", *lines, "", "hamr COMMAND --help shows options and examples.", ""])


def _module(name: str) -> ModuleType:
    return importlib.import_module(f".commands.{name}", __package__)


def _run(module: ModuleType, name: str, argv: list[str], *, as_json: bool) -> int:
    command = _parse(module, name, argv)
    with _result_only() as out:
        result = command.run()
        in_words = getattr(command, "text", as_text)
        out.write(as_json_text(result) if as_json else in_words(result))
    return 0 if result.get("ok", True) else FAILED


def _parse(module: ModuleType, name: str, argv: list[str]):
    if hasattr(module.Command, "from_words"):  # passes words on that are not ours to read
        return module.Command.from_words(argv)
    import tyro

    description = f"{module.__doc__}\nWith {AS_JSON}, standard output is one JSON object."
    parse = tyro.extras.subcommand_cli_from_dict if isinstance(module.Command, dict) else tyro.cli
    return parse(module.Command, prog=f"hamr {name}", description=description, args=argv)


@contextmanager
def _result_only() -> Iterator[TextIO]:
    """Yield standard output for the result; all else that is written there meanwhile, by children too, goes to standard error."""
    sys.stdout.flush()
    with os.fdopen(os.dup(1), "w") as out:
        os.dup2(2, 1)
        try:
            yield out
        finally:
            sys.stdout.flush()
            out.flush()
            os.dup2(out.fileno(), 1)


def _fail(sentence: str, status: int) -> int:
    sys.stderr.write(f"hamr: {sentence}\n")
    return status


if __name__ == "__main__":
    main()
