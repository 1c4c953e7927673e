"""The page: sliders, figures and numbers of one system, by Panel."""

import asyncio
import concurrent.futures
import html
import io
import threading
import time
from typing import Any

import panel as pn

from fastdyn.kernels.methods import METHODS
from fastdyn.plot.style import COLOURS
from fastdyn.words.letters import letters

from . import export, layout
from .exploration import Exploration, Way
from .figures import Figures
from .number import NumberSlider
from .sliders import CONSTANT_STEPS, END, TOLERANCES

PERIOD = 33  # milliseconds from one picture to the next
LONGEST = 10.0  # seconds in which a run is shown
SHORT = 0.1  # seconds that a picture waits for its curves; older ones are grey after that
OLDER = "the grey curves are those of before."
NO_SECOND = "none"
WRONG = (TypeError, ValueError, ArithmeticError)


class Page:
    """
    One system with sliders.

    Parameters
    ----------
    source : Source

    Attributes
    ----------
    exploration : Exploration
        What is chosen now.
    drawn : Exploration
        What the figures, the numbers and the saved files show.
    updates : int
        The number of times that the curves were drawn.
    """

    def __init__(self, source):
        self.exploration = self.drawn = Exploration(source)
        self.figures = Figures(self.exploration, self._drag)
        self.numbers, self.trouble = pn.pane.HTML("", name="numbers"), _alert("danger")
        self.waiting, self.dragged = (
            _alert("info"),
            pn.widgets.Button(label="The start was dragged: reset", visible=False),
        )
        self.dragged.on_click(self._reset)
        self.pause = pn.widgets.Toggle(label="Pause", width=80)
        self.updates = 0
        self._late = False
        self._ticking = False
        self._shown_at = 0.0
        self._last = time.monotonic()
        self._solve: Any = None  # a solve that was begun: exploration, new methods, future
        self.sliders = {one.name: self._slider(one) for one in self.exploration.sliders}
        self.choices = {name: self._choice(name) for name in self.exploration.choices}
        self.t_end = NumberSlider(
            "end (s)", self.exploration.t_end, start=END[0] * self.exploration.t_end,
            end=END[1] * self.exploration.t_end, step=END[0] * self.exploration.t_end,
            say=self._say, positive=True, name="end",
        )  # fmt: skip
        self.project = pn.widgets.Checkbox(label="hold the constraints by projection")
        self.methods = [self._way(n) for n in range(2)]
        self.axes = [self._axis(n) for n in range(2)]
        for widget in (self.t_end, self.project):
            widget.param.watch(self._changed, "value")
        self.update()

    # -- widgets

    def _slider(self, one):
        made = NumberSlider(
            one.title(), one.value, start=one.low, end=one.high, step=one.step, say=self._say,
            name=one.name,
        )  # fmt: skip

        def moved(event):
            self.exploration.values[one.name] = event.new
            if one.initial:
                self.exploration.y0 = None
            self._changed()

        made.param.watch(moved, "value")
        return made

    def _choice(self, name):
        known = self.exploration.choices[name]
        now = self.exploration.values[name]
        value = now if any(now is one for one in known.values()) else next(iter(known.values()))
        made = pn.widgets.Select(label=name, options=known, value=value)

        def chosen(event):
            self.exploration.values[name] = event.new
            self._changed()

        made.param.watch(chosen, "value")
        return made

    def _way(self, n):
        """The widgets of one way to solve: method, tolerance, step."""
        way = self.exploration.ways[0]
        names = list(METHODS) if n == 0 else [NO_SECOND, *METHODS]
        title, value = ("method", way.method) if n == 0 else ("second method", NO_SECOND)
        method = pn.widgets.Select(label=title, options=names, value=value)
        which = " of the second" * n
        rtol = pn.widgets.DiscreteSlider(
            label=f"relative tolerance{which}", value=way.rtol, formatter="%.0e",
            options=TOLERANCES,
        )  # fmt: skip
        step = pn.widgets.DiscreteSlider(
            label=f"constant step{which} (s)", value=way.step, formatter="%g", visible=False,
            options=CONSTANT_STEPS,
        )  # fmt: skip
        rtol.visible = n == 0
        for widget in (method, rtol, step):
            widget.param.watch(self._chosen, "value")
        return method, rtol, step

    def _chosen(self, event):
        """Take over the chosen methods, and show their widgets."""
        ways = []
        for method, rtol, step in self.methods:
            if method.value == NO_SECOND:
                rtol.visible = step.visible = False
                continue
            way = Way(method.value, rtol.value, step.value)
            rtol.visible = way.adaptive
            step.visible = not way.adaptive
            ways.append(way)
        self.exploration.ways = ways
        self._changed()

    def _axis(self, n):
        states = {letters(one.name): k for k, one in enumerate(self.exploration.make.states)}
        which = ("across", "upwards")[n]
        made = pn.widgets.Select(
            label=f"phase plane, {which}", options=states, value=getattr(self.exploration, which)
        )

        def chosen(event):
            setattr(self.exploration, which, event.new)
            self._changed()

        made.param.watch(chosen, "value")
        return made

    # -- changes

    def _drag(self, x, y):
        self.exploration.drag(x, y)
        self._changed()

    def _reset(self, *_):
        """Let the start follow the sliders again."""
        self.exploration.y0 = None
        self._changed()

    def _changed(self, *_):
        """Let the next picture draw anew, so that a fast slider causes no queue of solves."""
        self.exploration.t_end, self.exploration.project = self.t_end.value, self.project.value
        follows = self.exploration.y0 is None
        self.dragged.visible = not follows
        for one in self.exploration.sliders:
            if one.initial:
                self.sliders[one.name].disabled = not follows
        self._late = True
        if not self._ticking:
            self.update()
            self.tick()

    def update(self):
        """Solve and draw; after a mistake, print a sentence and leave the curves unchanged."""
        self._begin()
        self._draw(wait=None)

    def _begin(self):
        """Solve what is chosen now, in a thread."""
        self._late = False
        asked = self.exploration.copied()
        self._solve = (asked, asked.new_methods(), _started(asked.solve))

    def _draw(self, wait):
        """
        Draw the solve that was begun, if the solve ends in time, else make the older curves grey.

        Parameters
        ----------
        wait : float or None
            Seconds, None for as long as the solve takes.
        """
        asked, new, solve = self._solve
        try:
            solve.result(wait)
        except concurrent.futures.TimeoutError:
            compiled = f"The code of {' and '.join(new)} is compiled, once on this machine; "
            self._wait_for((compiled if new else "This solve takes longer; ") + OLDER)
            return
        except WRONG as error:
            self._say(str(error))
        else:
            self._say("")
            self.drawn = asked
            self.figures.update(asked)
            self.numbers.object = self._table()
            self.updates += 1
            self._shown_at = 0.0
        self._solve = None
        self._wait_for("")

    def _wait_for(self, sentence):
        """Say what the page waits for, and make the curves grey; an empty sentence ends this."""
        if sentence != self.waiting.object:
            self.waiting.param.update(object=sentence, visible=bool(sentence))
            for pane in self._panes:
                pane.styles = dict(layout.STALE if sentence else layout.FRESH)

    def _say(self, sentence):
        """Show a sentence about a mistake above the figures; an empty sentence clears it."""
        if sentence or self.trouble.visible:
            self.trouble.param.update(object=html.escape(sentence), visible=bool(sentence))

    def _table(self):
        """Numbers of the runs, as a table."""
        columns = {one.label: one.numbers() for one in self.drawn.shown}
        names = dict.fromkeys(name for column in columns.values() for name in column)
        signs = zip(columns, ("—", "- -"), COLOURS, strict=False)
        heads = [f'<td style="color:{colour}">{sign} {label}</td>' for label, sign, colour in signs]
        rows = ["<td></td>" + "".join(heads)]
        for name in names:
            cells = [name, *(column.get(name, "") for column in columns.values())]
            rows.append("".join(f"<td>{html.escape(cell)}</td>" for cell in cells))
        text = "".join(f"<tr>{row}</tr>" for row in rows)
        return f'<table class="numbers" style="border-spacing:1em 0.1em">{text}</table>'

    def tick(self):
        """Draw one picture: the curves of a solve that has ended, then the motion a bit later."""
        with pn.io.hold(pn.state.curdoc):
            wait = 0.0
            if self._late and self._solve is None:
                self._begin()
                wait = SHORT
            if self._solve is not None:
                self._draw(wait)
            self._move()
        if not self._ticking and pn.state.curdoc is None:
            pn.io.push_notebook(*self._panes)

    def _move(self):
        """Advance the motion by the time since the last picture."""
        now = time.monotonic()
        if not self.drawn.shown:
            return
        if not self.pause.value:
            span = self.drawn.shown[0].t[-1]
            self._shown_at += (now - self._last) * max(1.0, span / LONGEST)
            if self._shown_at >= span:
                self._shown_at = 0.0
                self.figures.clear_trail()
        self._last = now
        self.figures.move(self._shown_at)

    _panes: tuple = ()

    # -- the page

    def panel(self) -> Any:
        """The page as a Panel object."""
        drawn = [self.figures.motion, self.figures.phase, self.figures.against]
        if self.exploration.kept:
            drawn.append(self.figures.kept)
        self._panes = tuple(pn.pane.Bokeh(one, sizing_mode="stretch_width") for one in drawn)
        motion, *others = self._panes
        sides = [*self.sliders.values(), self.dragged, *self.choices.values(), self.t_end]
        if self.exploration.make.constraints and hasattr(self.exploration.make, "project"):
            sides.append(self.project)
        for one in self.methods:
            sides += one
        sides += [*self.axes, *self._files()]
        self._start_ticking()
        said = [self.trouble, self.waiting]
        return layout.page(sides, said, [motion, self.pause], others, self.numbers)

    def _files(self):
        name = self.exploration.source.name
        made = {
            f"{name}.png": lambda: io.BytesIO(export.picture(self.drawn)),
            f"{name}.py": lambda: io.StringIO(export.script(self.drawn)),
            f"{name}.csv": lambda: io.StringIO(export.table(self.drawn)),
        }
        return [
            pn.widgets.FileDownload(
                callback=text, filename=file, label=f"Save {file}", color="light"
            )
            for file, text in made.items()
        ]

    def _start_ticking(self):
        """Start the motion, if an event loop is running."""
        if pn.state.curdoc is None:
            try:
                asyncio.get_running_loop()
            except RuntimeError:
                return
        self._ticking = pn.state.curdoc is not None
        pn.state.add_periodic_callback(self.tick, period=PERIOD)


def _alert(kind):
    """A place for a sentence, empty at first."""
    return pn.pane.Alert("", alert_type=kind, visible=False)


def _started(work):
    """The future of work in a thread that does not keep the process alive."""
    future: concurrent.futures.Future = concurrent.futures.Future()

    def run():
        try:
            future.set_result(work())
        except BaseException as error:
            future.set_exception(error)

    threading.Thread(target=run, daemon=True, name="fastdyn explore").start()
    return future
