"""The command ``fastdyn``: its words, and the function of each word."""

import argparse
import contextlib
import os
import re
import sys
import warnings
from typing import NoReturn

from fastdyn import __version__
from fastdyn.words.near import did_you_mean

from . import beforehand, check, checks, commands, explore, export, find, page, run, sweep, why


def main(arguments=None):
    """
    Run the command line.

    Parameters
    ----------
    arguments : list of str, optional
        Words after the command; by default the words of the process.

    Returns
    -------
    int
        Exit status: 0 for success, 1 if a check or a run failed, 2 for wrong input, 141 if nobody
        reads the output on, as with ``head``.
    """
    words = sys.argv[1:] if arguments is None else list(arguments)
    status = 0
    try:
        try:
            status = _status(words)
        finally:
            print(end="", flush=True)
    except OSError as error:  # of what is printed: nobody reads on, or the disk is full
        _print_no_more()
        if isinstance(error, BrokenPipeError):
            return 141  # as of a process that SIGPIPE ends
        if status != 2:  # which says so already
            print(f"fastdyn: {error}", file=sys.stderr)
        return 2
    return status


def _print_no_more():
    """Discard the rest of the output, which Python would print at the end of the process."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    with contextlib.suppress(OSError, ValueError):  # of an output that is no file
        os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)


def _status(words):
    """Run the command of a command line; the exit status."""
    os.environ["MPLBACKEND"] = "Agg"  # the command writes files and opens no window
    try:
        with warnings.catch_warnings():
            warnings.showwarning = _in_a_sentence
            options = _parser(find.systems(words)).parse_args(checks.joined(words))
            return options.command(options)
    except BrokenPipeError:
        raise
    except FileNotFoundError as error:
        print(f"fastdyn: {checks.no_file(error.filename or str(error))}", file=sys.stderr)
        return 2
    except (TypeError, ValueError, ArithmeticError, OSError, ImportError) as error:
        print(f"fastdyn: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("fastdyn: interrupted.", file=sys.stderr)
        return 130


def _in_a_sentence(message, category, filename, lineno, file=None, line=None):
    """A warning as the command line says it, without the place in fastdyn that gives it."""
    print(f"fastdyn: {message}", file=sys.stderr)


class Parser(argparse.ArgumentParser):
    """A parser whose errors name the word that may be meant."""

    def parse_known_args(self, args=None, namespace=None):  # pyright: ignore
        """Refuse an option here, by the parser that knows which there are."""
        found, rest = super().parse_known_args(args, namespace)
        wrong = [word.partition("=")[0] for word in rest if word.startswith("--")]
        if wrong:
            known = [name for name in self._option_string_actions if name.startswith("--")]
            said = did_you_mean(wrong[0], known, form="{}") or f"there are {', '.join(known)}."
            self.error(f"there is no {wrong[0]}; {said}")
        return found, rest

    def error(self, message) -> NoReturn:
        """Print a sentence and leave, as argparse does."""
        wrong = re.search(r"(.*invalid choice: '(.*)') \(choose from (.*)\)", message)
        if wrong:
            known = re.findall(r"[^\s',]+", wrong[3])
            said = did_you_mean(wrong[2], known, form="{}")
            message = f"{wrong[1]}; {said}" if said else message
        super().error(message)


def _word(words, name, text):
    """The parser of a command, whose help begins with what the command does."""
    return words.add_parser(name, help=text, description=f"{text[0].upper()}{text[1:]}.")


def _parser(systems):
    parser = Parser(prog="fastdyn", description="Equations of motion, solved, checked and drawn.")
    parser.add_argument("--version", action="version", version=f"fastdyn {__version__}")
    words = parser.add_subparsers(required=True, metavar="COMMAND")

    tour = _word(words, "tour", "replay the course, with a table and figures")
    tour.add_argument("systems", nargs="*", metavar="SYSTEM", help="only these (default: all)")
    tour.add_argument("--out", default="fastdyn-tour", metavar="DIR", help="folder for figures")
    tour.set_defaults(command=commands.tour)

    gallery = _word(words, "gallery", "the figures of the tour, as a page")
    gallery.add_argument("--out", default="docs/gallery", metavar="DIR", help="folder of the page")
    gallery.set_defaults(command=commands.gallery)

    sheet = _word(words, "worksheet", "what to try on each system")
    sheet.add_argument("systems", nargs="*", metavar="SYSTEM", help="only these (default: all)")
    sheet.add_argument("--answers", action="store_true", help="compute the answers")
    sheet.set_defaults(command=commands.worksheet)

    handed_in = _word(words, "check", "a worksheet that was handed in")
    check.add_options(handed_in)
    handed_in.set_defaults(command=check.run)

    served = _word(words, "explore", "a page with sliders, in the browser")
    explore.add_options(served)
    served.set_defaults(command=explore.run)

    one_file = _word(words, "page", "a system as one file for a browser, without Python")
    page.add_options(one_file)
    one_file.set_defaults(command=page.run)

    source = _word(words, "export", "equations of motion in C or in JavaScript")
    export.add_options(source)
    source.set_defaults(command=export.run)

    listing = _word(words, "list", "systems and their parameters")
    listing.set_defaults(command=commands.list_systems)

    way = _word(words, "why", "how a function is compiled, and what prevents it")
    why.add_options(way)
    way.set_defaults(command=why.run)

    ahead = _word(words, "compile", "make the kernels of methods before a solve needs them")
    beforehand.add_options(ahead)
    ahead.set_defaults(command=beforehand.run)

    drift = _word(words, "drift", "follow the invariants of a system for long")
    known = {name: system for name, system in systems.items() if system.invariants}
    _add_systems(drift, commands.drift, _add_drift_options, known)
    many = _word(words, "sweep", "solve one system for many parameters")
    _add_systems(many, sweep.run, sweep.add_options, systems)
    one = _word(words, "run", "solve one system")
    _add_systems(one, run.run, run.add_options, systems)
    return parser


def _add_systems(parser, command, add_options, systems):
    """Teach the parser of a command the systems, each with options of its own."""
    derived = ", ".join(name for name in find.PAGES if name not in systems)
    parser.epilog = (
        "SYSTEM may also be FILE.py or FILE.py:NAME, a file that makes a System or a Model, or one "
        f"of the pages of fastdyn.derive: {derived}."
    )
    words = parser.add_subparsers(required=True, metavar="SYSTEM")
    for name, system in systems.items():
        title = system.title
        one = words.add_parser(name, help=title, description=title, allow_abbrev=False)
        add_options(one, system)
        one.set_defaults(command=command, system=system)


def _add_drift_options(parser, system):
    commands.add_fields(parser, system, checks.of_unit, "VALUE")
    study = parser.add_argument_group("study and output")
    study.add_argument("--methods", nargs="+", default=["Gauss16"], type=checks.method,
                       metavar="METHOD")  # fmt: skip
    several = checks.whole(1)
    for name, kind, text in (
        ("--step", checks.positive, "constant step (s)"),
        ("--steps-per-period", checks.positive, "constant steps in a period"),
        ("--rtol", checks.positive, "relative tolerance of adaptive methods"),
        ("--atol", checks.positive, "absolute tolerance of adaptive methods"),
        ("--evaluations", checks.positive, "a period, the same for all methods"),
        ("--seconds", checks.positive, "time of a period, the same for all methods"),
        ("--periods", checks.positive, "length of the run in periods"),
        ("--t-end", checks.positive, "length of the run (s)"),
        ("--n-steps", several, "length of the run in constant steps"),
    ):
        study.add_argument(name, type=kind, metavar="N", help=text)
    study.add_argument("--samples", type=several, default=1000, metavar="N",
                       help="bins that are kept")  # fmt: skip
    study.add_argument("--checkpoint", metavar="FILE", help="go on from here, and write it")
    study.add_argument("--plot", metavar="FILE", type=checks.file(checks.FIGURES),
                       help="write the figure, .png, .pdf or .svg")  # fmt: skip
