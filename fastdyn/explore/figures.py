"""The four figures of a page, by Bokeh: motion, phase portrait, components, invariant."""

from typing import Any

import numpy as np
from bokeh.models import ColumnDataSource, CustomJSTickFormatter, DataRange1d, PointDrawTool
from bokeh.plotting import figure

from fastdyn.plot.style import COLOURS, GROUND, named

from .pictures import arrows, columns, rectangle, under

SIZE: Any = {"width": 300, "height": 320, "sizing_mode": "stretch_width"}
SHAPED: Any = {"aspect_ratio": 1.0, "height": None, "sizing_mode": "stretch_width",
               "max_width": 720}  # fmt: skip
SHORT = "return String(Number(tick.toPrecision(4)))"  # 1e-9 and 0, not 1.000e-9 and 0.000e+0
TOOLS = "pan,wheel_zoom,box_zoom,reset"
TALL, WIDE = 0.8, 1.8  # of the motion: width over height, which follows the motion between these
FEWEST, OFTEN = 150, 40  # fewest points of a trail; most points between two pictures


class Figures:
    """
    The figures of an exploration.

    Parameters
    ----------
    exploration : Exploration
        The system, not solved yet.
    dragged : callable
        Called with x and y after the start was dragged in the phase plane.
    """

    def __init__(self, exploration, dragged):
        self.drawn = exploration
        self._dragged = dragged
        self.curves = [_source("t a b", f"curve {n}") for n in range(2)]
        self.changes = [_source("t e", f"change {n}") for n in range(2)]
        self.start, self.corners = _source("x y"), _source("x y")
        self.arrows, self.names = _source("xs ys"), _source("x y name")
        self.ground = _source("xs ys")
        self.parts, self.beside = _parts("trail"), _parts("trail beside")
        self.motion, self.phase = self._motion(), self._phase()
        self.against = _lines(self.curves, "t", "a", "t (s)")
        self.kept = _lines(self.changes, "t", "e", "t (s)")
        self.kept.yaxis.formatter = CustomJSTickFormatter(code=SHORT)
        self._show: Any = None
        self._named()

    def _motion(self):
        found = figure(
            tools="", toolbar_location=None, x_range=DataRange1d(range_padding=0.0),
            y_range=DataRange1d(range_padding=0.0), match_aspect=True, **SHAPED,
        )  # fmt: skip
        corners = found.scatter("x", "y", source=self.corners, size=0)
        sides: Any = (found.x_range, found.y_range)
        for side in sides:
            side.renderers = [corners]  # the motion stays in a picture that does not move
        found.patches("xs", "ys", source=self.ground, color=GROUND, alpha=0.45, line_alpha=0.0)
        found.multi_line("xs", "ys", source=self.arrows, color="gray")
        found.text(
            "x", "y", "name", source=self.names, text_color="gray", text_font_size="13px",
            text_baseline="middle", text_align="center",
        )  # fmt: skip
        parts = self.parts
        beside = self.beside
        found.line("x", "y", source=parts["trail"], color=COLOURS[5])
        second: Any = {"line_color": COLOURS[1], "line_dash": "dashed"}
        found.line("x", "y", source=beside["trail"], line_alpha=0.5, **second)
        about: Any = {"fill_color": COLOURS[4], "line_color": "#4d4d4d"}
        found.patches("xs", "ys", source=parts["bodies"], fill_alpha=0.85, **about)
        found.patches("xs", "ys", source=beside["bodies"], fill_alpha=0.0, **second)
        found.multi_line("xs", "ys", source=parts["lines"], color="#4d4d4d", line_width=2)
        found.multi_line("xs", "ys", source=beside["lines"], **second)
        found.scatter("x", "y", source=parts["fixed"], color="gray", size=9)
        found.scatter("x", "y", source=parts["points"], color=COLOURS[0], size=11)
        found.scatter("x", "y", source=beside["points"], color=COLOURS[1], size=8)
        return found

    def _phase(self):
        found = _lines(self.curves, "a", "b", "")
        point = found.scatter("x", "y", source=self.start, size=14, color="black", alpha=0.7)
        tool = PointDrawTool(renderers=[point], add=False)
        found.add_tools(tool)
        found.toolbar.active_tap = tool
        found.toolbar.active_drag = tool
        self.start.on_change("data", self._moved)
        return found

    def _moved(self, name, old, new):
        x = list(new["x"])
        y = list(new["y"])
        if len(x) == 1 and (x[0], y[0]) != self._placed:
            self._dragged(x[0], y[0])

    def _named(self):
        """Write the names of the components that are shown on the axes."""
        one = self.drawn
        states = self.drawn.make.states
        across = named(states[one.across])
        upwards = named(states[one.upwards])
        self.phase.xaxis.axis_label = across
        self.phase.yaxis.axis_label = upwards
        self.against.yaxis.axis_label = across
        title: Any = self.motion.title
        title.text = title.text or self.drawn.make.title  # without a text, there is no room for one
        self.phase.title = "phase plane: drag the start"
        self.against.title = "against time"
        self.phase.match_aspect = states[one.across].unit == states[one.upwards].unit

    def update(self, solved):
        """Show the results of an exploration."""
        self.drawn = one = solved
        self._named()
        for n, (curve, change) in enumerate(zip(self.curves, self.changes, strict=True)):
            if n < len(one.shown):
                shown = one.shown[n]
                curve.data = {"t": shown.t, "a": shown.y[one.across], "b": shown.y[one.upwards]}
                t = shown.kept_t[: len(shown.kept)]
                change.data = {"t": t, "e": shown.kept}
            else:
                curve.data = {"t": [], "a": [], "b": []}
                change.data = {"t": [], "e": []}
        first = one.shown[0].y[:, 0]
        self._placed = (float(first[one.across]), float(first[one.upwards]))
        self.start.data = {"x": [self._placed[0]], "y": [self._placed[1]]}
        if len(one.shown[0].kept):
            self.kept.title = one.shown[0].kept_name
        staged = one.stage()
        self._show = None
        if staged is not None:
            limits, self._show = staged
            self._set(limits, self._show(0.0))
        self.clear_trail()
        for source in self.beside.values():
            nothing: Any = {name: [] for name in source.data}
            source.data = nothing

    def _set(self, limits, scene):
        """The axes of the motion: those of a plane, or three arrows of one length in space."""
        x, y = rectangle(limits, scene.down)
        self.corners.data = {"x": x, "y": y}
        self.motion.aspect_ratio = min(max((x[1] - x[0]) / (y[1] - y[0]), TALL), WIDE)
        self.ground.data = under(limits, scene.ground)
        upwards: Any = self.motion.y_range
        upwards.flipped = scene.down and len(limits) == 2
        space = len(limits) == 3
        self.motion.axis.visible = self.motion.grid.visible = not space
        if space:
            lines, texts = arrows(limits, scene)
            self.arrows.data = lines
            self.names.data = texts
        else:
            self.motion.xaxis.axis_label, self.motion.yaxis.axis_label = scene.axes[:2]

    def move(self, time):
        """Show the system at a time of the run."""
        if self._show is None:
            return
        for n, shown in enumerate(self.drawn.shown):
            parts = (self.parts, self.beside)[n]
            for name, found in columns(self._show(time, n)).items():
                before = parts[name].data
                if any(len(found[key]) or len(before[key]) for key in found):
                    parts[name].data = found
            t = shown.t
            since = time if self._until < 0.0 else self._until
            new = t[np.searchsorted(t, since, "right") : np.searchsorted(t, time)]
            if len(new) > OFTEN:
                new = new[np.linspace(0, len(new) - 1, OFTEN).astype(int)]
            traced = [_traced(self._show(one, n)) for one in (*new, time)]
            path = dict(zip("xy", np.array(traced).T, strict=True))
            if self._until < 0.0:
                parts["trail"].data = path
            else:
                parts["trail"].stream(path, rollover=max(FEWEST, len(t) // 2))
        self._until = time
        title: Any = self.motion.title
        note = self._show(time).note
        told = (self.drawn.make.title, f"t = {time:.2f} s", note)
        title.text = ", ".join(filter(None, told))

    def clear_trail(self):
        """Begin a new trail when the motion begins again."""
        self._until = -1.0  # before the first time of a run

    _placed: tuple = ()


def _parts(trail):
    """The sources of the parts of a scene."""
    return {
        "bodies": _source("xs ys"), "lines": _source("xs ys"), "fixed": _source("x y"),
        "points": _source("x y"), "trail": _source("x y", trail),
    }  # fmt: skip


def _traced(scene):
    """The point of a scene that leaves a trail, in the plane of the picture."""
    point = columns(scene._replace(points=[scene.traced], lines=[], bodies=[], fixed=[]))["points"]
    return float(point["x"][0]), float(point["y"][0])


def _source(names, name=None):
    return ColumnDataSource({column: [] for column in names.split()}, name=name)


def _lines(sources, x, y, label) -> Any:
    """A figure with the curves of both ways."""
    found = figure(tools=TOOLS, **SIZE)
    for source, colour, dash in zip(sources, COLOURS, ("solid", "dashed"), strict=False):
        found.line(x, y, source=source, color=colour, line_width=2, line_dash=dash)
    found.xaxis.axis_label = label
    return found
