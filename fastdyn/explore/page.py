"""The page: sliders, figures and numbers of one system, by Panel."""

import asyncio
import html
import io
import time
from typing import Any

import panel as pn

from fastdyn.kernels.methods import METHODS
from fastdyn.plot.style import COLOURS

from . import export, layout
from .exploration import Exploration, Way
from .figures import Figures
from .number import NumberSlider

PERIOD = 33  # milliseconds from one picture to the next
LONGEST = 10.0  # seconds in which a run is shown
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
    updates : int
        The number of times that the curves were drawn.
    """

    def __init__(self, source):
        self.exploration = Exploration(source)
        self.figures = Figures(self.exploration, self._drag)
        self.numbers, self.trouble = pn.pane.HTML("", name="numbers"), pn.pane.Alert("")
        self.trouble.param.update(alert_type="danger", visible=False)
        self.updates, self._late, self._ticking, self._begun = 0, False, False, time.monotonic()
        self.sliders = {one.name: self._slider(one) for one in self.exploration.sliders}
        self.choices = {name: self._choice(name) for name in self.exploration.choices}
        self.t_end = NumberSlider(
            "end (s)", self.exploration.t_end, start=0.05 * self.exploration.t_end,
            end=5.0 * self.exploration.t_end, step=0.05 * self.exploration.t_end,
            say=self._say, positive=True, name="end",
        )  # fmt: skip
        self.project = pn.widgets.Checkbox(name="hold the constraints by projection")
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
                self.exploration.y0 = None  # the start follows the sliders again
            self._changed()

        made.param.watch(moved, "value")
        return made

    def _choice(self, name):
        known = self.exploration.choices[name]
        now = self.exploration.values[name]
        value = now if any(now is one for one in known.values()) else next(iter(known.values()))
        made = pn.widgets.Select(name=name, options=known, value=value)

        def chosen(event):
            self.exploration.values[name] = event.new
            self._changed()

        made.param.watch(chosen, "value")
        return made

    def _way(self, n):
        """The widgets of one way to solve: method, tolerance, step."""
        way = self.exploration.ways[0]
        names = list(METHODS) if n == 0 else [NO_SECOND, *METHODS]
        title, value = ("method", way.method) if n == 0 else ("beside it", NO_SECOND)
        method = pn.widgets.Select(name=title, options=names, value=value)
        rtol = pn.widgets.DiscreteSlider(
            name="relative tolerance", options=[10.0**-k for k in range(2, 14)], value=way.rtol,
            formatter="%.0e",
        )  # fmt: skip
        step = pn.widgets.DiscreteSlider(
            name="constant step (s)", value=way.step, formatter="%g", visible=False,
            options=[m * 10.0**-k for k in (4, 3, 2, 1) for m in (1.0, 2.0, 5.0)],
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
            rtol.visible, step.visible = way.adaptive, not way.adaptive
            ways.append(way)
        self.exploration.ways = ways
        self._changed()

    def _axis(self, n):
        states = {one.name: k for k, one in enumerate(self.exploration.make.states)}
        which = ("across", "upwards")[n]
        made = pn.widgets.Select(
            name=f"phase plane, {which}", options=states, value=getattr(self.exploration, which)
        )

        def chosen(event):
            setattr(self.exploration, which, event.new)
            self.figures.named()
            self._changed()

        made.param.watch(chosen, "value")
        return made

    # -- changes

    def _drag(self, x, y):
        self.exploration.drag(x, y)
        self._changed()

    def _changed(self, *_):
        """Let the next picture draw anew, so that a fast slider causes no queue of solves."""
        self.exploration.t_end, self.exploration.project = self.t_end.value, self.project.value
        self._late = True
        if not self._ticking:
            self.tick()

    def update(self):
        """Solve and draw; after a mistake, print a sentence and leave the curves unchanged."""
        self._late = False
        try:
            self.exploration.solve()
        except WRONG as error:
            self._say(str(error))
            return
        self._say("")
        self.figures.update()
        self.numbers.object = self._table()
        self.updates += 1

    def _say(self, sentence):
        """Show a sentence about a mistake above the figures; an empty sentence clears it."""
        if sentence or self.trouble.visible:
            self.trouble.param.update(object=html.escape(sentence), visible=bool(sentence))

    def _table(self):
        """Numbers of the runs, as a table."""
        columns = {one.label: one.numbers() for one in self.exploration.shown}
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
        """Draw one picture: solve if something has changed, then advance the motion."""
        with pn.io.hold(pn.state.curdoc):  # the lowest Panel finds no document by itself
            if self._late:
                self.update()
            span = self.exploration.shown[0].t[-1]
            shown = min(span, LONGEST)
            along = (time.monotonic() - self._begun) / shown
            if along >= 1.0:
                self._begun, along = time.monotonic(), 0.0
                self.figures.clear_trail()
            self.figures.move(along * span)
        if not self._ticking and pn.state.curdoc is None:
            pn.io.push_notebook(*self._panes)

    _panes: tuple = ()

    # -- the page

    def panel(self) -> Any:
        """The page as a Panel object."""
        drawn = [self.figures.motion, self.figures.phase, self.figures.against]
        if self.exploration.kept:
            drawn.append(self.figures.kept)
        self._panes = tuple(pn.pane.Bokeh(one, sizing_mode="stretch_width") for one in drawn)
        sides = [*self.sliders.values(), *self.choices.values(), self.t_end]
        if self.exploration.make.constraints and hasattr(self.exploration.make, "project"):
            sides.append(self.project)
        for one in self.methods:
            sides += one
        sides += [*self.axes, *self._files()]
        self._start_ticking()
        return layout.page(sides, self.trouble, self._panes, self.numbers)

    def _files(self):
        name, one = self.exploration.source.name, self.exploration
        made = {
            f"{name}.png": lambda: io.BytesIO(export.picture(one)),
            f"{name}.py": lambda: io.StringIO(export.script(one)),
            f"{name}.csv": lambda: io.StringIO(export.table(one)),
        }
        return [
            pn.widgets.FileDownload(
                callback=text, filename=file, label=f"Save {file}", button_type="light"
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
