"""The functions of a system in JavaScript, for each of its choices, and what is said of them."""

import dataclasses
import itertools
import math
from typing import Any, NamedTuple

import numpy as np

from fastdyn.explore.exploration import GROUND
from fastdyn.explore.pictures import flat
from fastdyn.explore.sliders import END
from fastdyn.problem.events import Event
from fastdyn.problem.second_order_and_pairs import is_second_order
from fastdyn.systems.base.export import of_arguments, of_instance
from fastdyn.trace.emit.source.files import javascript
from fastdyn.trace.emit.source.functions import Exported, NotExported
from fastdyn.trace.switching.switches import switches
from fastdyn.words.letters import letters

MOVED = 1.05  # a number by which a parameter is moved, to see whether shapes follow
SEEN = 1e-3  # of the size of a picture: less is not seen
DRAWS = 3  # of parameters within the ranges of sliders, at which switching times are sought
GROUPS = ("invariants", "quantities", "constraints")


NO_TIMES = (
    "A page has no form of steps that end at given times, and could lose a pulse: {}. Solve it in "
    "Python, or serve it by `fastdyn explore`."
)


class PageText(NamedTuple):
    """The functions of a system with its choices, as the text of an object in JavaScript."""

    chosen: dict
    text: str
    used: str  # all statements, for the helpers that they call


class PageFunctions:
    """
    The functions of a system on a page.

    Parameters
    ----------
    system : System

    Attributes
    ----------
    numbers : list of str
        Names of the fields that are p[0], p[1] ... on the page.
    values : list of dict
        What is drawn besides the state: name, label, unit, group.
    events : list of dict
        name, direction, terminal, and whether it `ends` a run.
    derived : list of dict
        Answers that follow from the parameters: name, unit; `fixed` if they are known for the first
        values of the sliders only.
    scene : dict or None
        The parts of the picture, its axes, and names of the numbers that its shapes do not follow.
    left_out : list of str
        Sentences about functions that have no form in JavaScript.
    second_order : bool
        Whether the equations are q'' = a(t, q).
    """

    def __init__(self, system):
        self.system, make = system, type(system)
        self.names = [one for one in dataclasses.fields(system) if "unit" in one.metadata]
        self.numbers = [one.name for one in self.names]
        self.values = []
        self.events = []
        self.derived = []
        self.left_out = []
        self.second_order = True
        self.scene: Any = None
        self.quantities: dict = {
            name: (function, group)
            for group in GROUPS
            for name, function in getattr(make, group).items()
        }
        choices = {name: list(known) for name, known in make.choices.items() if known}
        self.texts = [
            self._text(dict(zip(choices, words, strict=True)))
            for words in itertools.product(*choices.values())
        ]

    def _text(self, chosen):
        make = type(self.system)
        given = {name: make.choices[name][word] for name, word in chosen.items()}
        system = dataclasses.replace(self.system, **given)
        parts = _Parts(system, self.numbers)
        first = not self.events and not self.values
        if system.breakpoints is not None:
            raise NotExported(NO_TIMES.format(f"the {make.name} has breakpoints"))
        rhs = parts.of(system.rhs, (len(system.states),), "rhs")
        if _switches(rhs, END[1] * make.t_end):
            raise NotExported(NO_TIMES.format(f"the equations of {make.name} switch with the time"))
        self.second_order &= is_second_order(rhs.trace, len(system.states))
        parts.add("rhs", rhs)
        self._start(system, parts)
        if hasattr(make, "project"):
            self._allowed(parts, "project", system.project, (len(system.states),))
        phases = system.phases()
        if phases:
            self._phases(system, phases, parts)
        self._listed(system, parts, first)
        self._picture(system, parts, first)
        return PageText(chosen, parts.text(), "\n".join(parts.statements))

    def _allowed(self, parts, name, function, shape):
        """Add a function; without one, a sentence says that it is not on the page."""
        try:
            parts.add(name, parts.of(function, shape, name))
        except NotExported as reason:
            self._leave_out(reason)

    def _leave_out(self, reason):
        if str(reason) not in self.left_out:
            self.left_out.append(str(reason))

    def _start(self, system, parts):
        n = len(system.states)
        settle = getattr(system, "settling", None)
        if settle is None:
            parts.add("start", parts.of_system(type(system).initial_state, (n,), "initial_state"))
            return
        begin, groups = settle()
        parts.add("start", parts.of_numbers(begin, (n,), "start"))
        settled = []
        for function, count, free, first in groups:
            name = f"residuals_{first}"
            size = count * (len(free) + 1)
            written = parts.source(name, parts.of_numbers(function, (size,), name))
            listed = ", ".join("true" if one else "false" for one in free)
            settled.append(f"[{{of: {written}, count: {count}, free: [{listed}]}}, {first}]")
        parts.members.append(f"settle: [{', '.join(settled)}]")

    def _phases(self, system, phases, parts):
        """Phases by number, each with its equations, its end, and the next one."""
        n = len(system.states)
        names = list(phases)
        listed = []
        for phase_name, phase in phases.items():
            end = Event.of(phase.event)
            if end.limit > 1 or end.beyond("limit", "direction"):
                raise NotExported(
                    f"The phase {phase_name} ends at some crossings of its event alone, by "
                    "`terminal` or `wait`: a page ends a phase at the first one."
                )

            def after(t, y, *args, after=phase.after):
                name, state = after(t, y, *args)
                return [names.index(name), *state]

            members = {
                "f": parts.of(phase.fun, (n,), "rhs"),
                "ends": parts.of(end.function, None, "event"),
                "after": parts.of(after, (n + 1,), "after"),
            }  # fmt: skip
            if project := phase.options.get("project"):
                members["project"] = parts.of(project, (n,), "project")
            texts = [f"{key}: {parts.source(key, one)}" for key, one in members.items()]
            texts.append(f"direction: {end.direction!r}")
            listed.append(f"{{{', '.join(texts)}}}")

        def first(t, y, system):
            name, state = system.first_phase(y)
            return [names.index(name), *state]

        parts.add("first", parts.of_system(first, (n + 1,), "first_phase", with_time=True))
        parts.members.append(f"phases: [{', '.join(listed)}]")

    def _listed(self, system, parts, first):
        """Quantities, events and derived answers, each as an array of functions."""
        make = type(system)
        known = []
        for name, (function, group) in self.quantities.items():
            try:
                known.append(parts.source(name, parts.of(function, None, name)))
            except NotExported as reason:
                self._leave_out(reason)
                known.append("null")
            if first:
                about = {"name": name, "unit": function.unit, "group": group}
                self.values.append(about | {"label": _label(function.label)})
        parts.members.append(f"values: [{', '.join(known)}]")
        watched = {name: Event.of(one) for name, one in make.events.items()}
        watched = {name: one for name, one in watched.items() if self._follows(name, one)}
        events = [parts.source(n, parts.of(e.function, None, n)) for n, e in watched.items()]
        parts.members.append(f"events: [{', '.join(events)}]")
        if first:
            self.events = [
                {
                    "name": name, "direction": one.direction, "terminal": one.limit > 0,
                    "ends": self._ends(name, one.limit),
                }
                for name, one in watched.items()
            ]  # fmt: skip
        answers = []
        for name, unit in make.derived.items():
            about = {"name": name, "unit": unit}
            try:
                found = parts.of_system(make.__dict__.get(name) or getattr(make, name), None, name)
                answers.append(parts.source(name, found))
            except NotExported:
                answers.append("null")
                about["fixed"] = _told(system, name)
            if first:
                self.derived.append(about)
        parts.members.append(f"derived: [{', '.join(answers)}]")

    def _follows(self, name, one):
        """Whether the page has all rules of an Event; a sentence says which it has not."""
        others = one.beyond("limit", "direction")
        if others:
            self._leave_out(
                f"The event {name} is not sought here, where no event has `{'`, `'.join(others)}`: "
                "solve in Python."
            )
        return not others

    def _ends(self, name, limit):
        """Whether an event ends the runs of the page: the ground, and what a user's events end."""
        if limit > 1:
            self._leave_out(
                f"The event {name} ends no run here, where its occurrences are not counted; in "
                f"Python, its occurrence {limit} does."
            )
            return False
        return limit > 0 and (name == GROUND or getattr(self.system, "of_function", False))

    def _picture(self, system, parts, first):
        """The function that gives the coordinates of a picture, and what its parts are."""
        start = np.array(system.initial_state(), float)
        try:
            run = system.solve(dense_output=True)
            stage = system.stage(run.t, np.asarray(run.y))
            scene = stage(0.0, start)
        except ValueError:
            return
        shape = (len(_coordinates(scene)),)
        try:
            if hasattr(system, "derivation"):
                function = lambda t, y, *args: _coordinates(stage(t, y, args))  # noqa: E731
                picture = parts.of(function, shape, "picture")
            else:
                function = lambda t, y, system: _coordinates(system.scene(t, y))  # noqa: E731
                picture = parts.of_system(function, shape, "picture", with_time=True)
        except NotExported as reason:
            self._leave_out(reason)
            return
        parts.add("picture", picture)
        if first:
            still = _still(system, run, stage) if hasattr(system, "derivation") else []
            self.scene = _about(scene) | {"still": still}


class _Parts:
    """The members of an object in JavaScript, from functions that are traced."""

    def __init__(self, system, numbers):
        self.system = system
        self.numbers = numbers
        self.members = [f"n: {len(system.states)}"]
        self.statements = []

    def of(self, function, shape, name):
        """A function of (t, y, *parameters)."""
        return of_arguments(self.system, function, shape, self.numbers, name)

    def of_system(self, function, shape, name, with_time=False):
        """A function of the system, or of (t, y, system)."""
        own: Any = function.fget if isinstance(function, property) else function
        taken = own if with_time else (lambda t, y, system: own(system))
        return of_instance(self.system, taken, shape, self.numbers, name)

    def of_numbers(self, function, shape, name):
        """A function of (t, y, *all numbers)."""
        args = tuple(getattr(self.system, one) for one in self.numbers)
        places = {i: i - 1 for i in range(1, len(args) + 1)}
        return Exported(function, args, len(self.system.states), shape, places, name)

    def source(self, name, exported):
        text = javascript("", exported.written("js"))
        self.statements.append(text)
        return text

    def add(self, name, exported):
        self.members.append(f"{name}: {self.source(name, exported)}")

    def text(self):
        return "{" + ",\n".join(self.members) + "}"


def _switches(rhs, t_end):
    """Whether equations switch with the time alone, for some values of their parameters."""
    found = switches(rhs.trace.graph, rhs.outputs, ())
    if found is None:
        return False
    first = np.array(rhs.trace.graph.values)
    draws = np.random.default_rng(0)
    tried = [first, *(first * draws.uniform(0.1, 3.0, len(first)) for _ in range(DRAWS))]
    return any(len(found.times(values, 0.0, t_end).t) for values in tried)


def _coordinates(scene):
    """All coordinates of a scene in the plane of the picture, part by part."""
    found = []
    for part in (*scene.bodies, *scene.lines, *scene.fixed, *scene.points, scene.traced):
        x, y = flat(part, scene.down)
        found += [np.ravel(x), np.ravel(y)]
    for corner in scene.frame:
        found += [np.ravel(x) for x in corner]
    return np.concatenate(found)


def _about(scene):
    """The parts of a scene: kind and number of points, in the order of `_coordinates`."""
    parts = [
        [kind, int(np.size(part[0]))]
        for kind in ("bodies", "lines", "fixed", "points")
        for part in getattr(scene, kind)
    ]
    parts.append(["trail", 1])
    parts += [["frame", 1]] * len(scene.frame)
    space = len(scene.traced) == 3
    ground = scene.ground if not space else None
    return {
        "parts": parts, "axes": list(scene.axes), "space": space, "note": scene.note,
        "down": bool(scene.down and not space), "ground": ground,
    }  # fmt: skip


def _still(system, run, stage):
    """Names of the numbers that shapes of a derived picture, made for a run, do not follow."""
    t = run.t
    y = np.asarray(run.y)
    found = []
    middle = len(t) // 2
    for field in system.parameter_fields():
        if "unit" not in field.metadata:
            continue
        try:
            other = dataclasses.replace(system, **{
                field.name: MOVED * getattr(system, field.name) + (MOVED - 1.0)
            })  # fmt: skip
            right = _coordinates(other.stage(t, y)(t[middle], y[:, middle]))
        except ValueError:  # no such body
            continue
        here = _coordinates(stage(t[middle], y[:, middle], other.args))
        if here.shape != right.shape or np.abs(here - right).max() > SEEN * np.ptp(right):
            found.append(field.name)
    return found


def _label(text):
    """A label whose words are letters, where they are names: "reaction λ_gap"."""
    return " ".join(letters(word) if "_" in word else word for word in text.split(" "))


def _told(system, name):
    """A derived answer for the first values, as a number or a text; None if there is none."""
    try:
        found = getattr(system, name)
    except (ValueError, ArithmeticError):
        return None
    if isinstance(found, str):
        return found
    return None if math.isnan(found) else found if math.isfinite(found) else "∞"
