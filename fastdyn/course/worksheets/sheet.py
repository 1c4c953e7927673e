"""A worksheet as text: the questions by system, then the answers."""

import textwrap

from fastdyn.systems import SYSTEMS

from . import exercises

WIDTH = 100


def sheet(names=None, answers=False):
    """
    The worksheet on the named systems, all unless given.

    Returns
    -------
    list of str
        Lines of Markdown.
    bool
        Whether all answers, if they were computed, are what the exercises expect.
    """
    names = list(names or SYSTEMS)
    lines = ["# Worksheets"]
    solved = ["", "## Answers"]
    hold = True
    for name in names:
        lines += ["", f"## {SYSTEMS[name].title}"]
        solved += ["", f"{SYSTEMS[name].title}:", ""] if answers else []
        for number, one in enumerate(exercises(name), 1):
            lines += ["", *_item(number, one.question)]
            lines += ["", f"    `fastdyn {one.command}`"] if one.command else []
            if answers:
                answer = one.answer()
                hold = hold and answer.holds
                solved += _item(number, answer.text)
    return [*lines, *(solved if answers else [])], hold


def _item(number, text):
    """An entry of a numbered list."""
    return textwrap.wrap(f"{number}.  {text}", WIDTH, subsequent_indent="    ")
