"""Systems with friction: solved through slip and rest."""

from typing import Any, ClassVar

import numpy as np

from fastdyn.derive.checks.inputs import refuse_negative
from fastdyn.derive.checks.runs import warn_of_pull
from fastdyn.derive.system import DerivedSystem
from fastdyn.run.dense_output import PiecewisePolynomial
from fastdyn.solve.phases import solve_phases
from fastdyn.systems.base.consistent_start import start
from fastdyn.systems.base.declare import of_instance
from fastdyn.systems.base.result import SystemResult, asked
from fastdyn.systems.base.solve_arguments import completed, span

from .modes import REST, ContactMode, Way
from .transitions import Transitions


class RubbingSystem(DerivedSystem):
    """
    A derived system with contacts that slip and rest; `rhs` holds while all slip forwards.

    `solve` goes through the phases of slip and rest, each with its own equations.
    """

    made: ClassVar[dict[tuple[Way | None, ...], ContactMode]]

    def __init_subclass__(cls, **options):
        super().__init_subclass__(**options)
        cls.made = {}

    def __post_init__(self):
        super().__post_init__()
        for one in self.derivation.model.contacts:
            refuse_negative(f"at {one.name} of the {self.name}", *self._coefficients(one))

    @of_instance
    def solve(
        self, t_span: Any = None, y0: Any = None, method: Any = "RK45", project=None, **options: Any
    ):
        """
        Solve through slip and rest; see `fastdyn.solve.phases.solve_phases`.

        Parameters
        ----------
        t_span, y0, method, **options
            As for `System.solve`; an event function of yours is given the state alone.
        project : bool, optional
            As for `System.solve`. What rests is held at rest by projection in any case.

        Returns
        -------
        SystemResult
            With `phases`, a list of (name, start, end): "slips", "slips back" or "rests", of each
            contact if there are several.

        Raises
        ------
        ValueError
            As `System.solve` does, if contacts at rest do not determine their friction, and if no
            mode agrees with the signs of slips and reactions (Painlevé's paradox).
        """
        if callable(project):
            raise ValueError(f"`project` of the {self.name} is its own: True or False.")
        self.refuse_coincidence(t_span, y0)
        options = completed(self, method, options)
        t_span = span(self, t_span)
        w = np.array(start(self, t_span[0], y0, project), float)
        n = len(w)
        count = len(self.derivation.model.contacts)
        given = options
        options = _widened(options, n, count)
        run = Transitions(self, lambda mode: self._phase(mode, bool(project)))
        first = run.begin(t_span[0], w)
        w = np.append(w, np.zeros(count))
        found = solve_phases(run, first, t_span, w, method, args=self.args, **options)
        again = asked(found, t_span, y0, method, project, given)
        result = RubbingResult(_narrowed(found, n), self.as_started(t_span[0], y0), again)
        object.__setattr__(result, "ways", [run.ways[name] for name, *_ in found.phases])
        warn_of_pull(result, result.at_points)
        return result

    def phases(self):
        """Refused: the modes are made along a run, where slip and rest meet."""
        raise ValueError(
            f"The {self.name} slips and rests, and the equations of each mode are made where the "
            "motion meets it: no file has them beforehand. Solve it in Python."
        )

    @of_instance
    def ensemble(self, t_span=None, y0=None, method="RK45", **given):
        """Refused: a motion in phases is solved one by one."""
        raise ValueError(
            f"The {self.name} slips and rests, which is solved one by one: call `solve` in a loop."
        )

    def rough(self, contact):
        """Whether a contact has friction, with these parameters."""
        return any(one != 0 for one in self._coefficients(contact))

    def _coefficients(self, contact):
        """Coefficients of friction of a contact, with these parameters."""
        numbers = {
            one.symbol: getattr(self, str(one.symbol)) for one in self.derivation.model.numbers
        }
        both = contact.friction, contact.static
        return [self.derivation.plain(one).xreplace(numbers) for one in both]

    def mode(self, ways):
        """The `Mode` of some ways, made when it is first needed."""
        if ways not in self.made:
            derivation = self.derivation
            resting = frozenset(
                contact.name
                for contact, way in zip(derivation.model.contacts, ways, strict=True)
                if way == REST
            )
            known = [one for one in self.made.values() if one.derivation.at_rest == resting]
            again = known[0].derivation if known else derivation
            if again.at_rest != resting:
                again = type(derivation)(derivation.model, derivation.law, resting)
            self.made[ways] = ContactMode(again, ways)
        return self.made[ways]

    @staticmethod
    def _phase(mode, project):
        """Equations and options of a mode; `Transitions` says what comes after."""
        held = mode.project is not None and (project or REST in mode.ways)
        return mode.rhs, mode.ends, {"project": mode.project} if held else {}


def _widened(options, n, count):
    """Options for a state with further components: tolerances for them, events without them."""
    options = dict(options)
    if np.ndim(options.get("atol", 0.0)) == 1 and len(options["atol"]) == n:
        options["atol"] = np.append(options["atol"], [np.min(options["atol"])] * count)
    if (events := options.get("events")) is not None:
        events = [events] if callable(events) else events
        options["events"] = [_of_the_first(n, one) for one in events]
    return options


def _of_the_first(n, function):
    """An event function that is given the first n components."""

    def narrowed(t, w, *args):
        return function(t, w[:n], *args)

    for name in ("direction", "terminal"):
        if hasattr(function, name):
            setattr(narrowed, name, getattr(function, name))
    return narrowed


def _narrowed(found, n):
    """A result without the further components."""
    found.y = found.y[:n] if len(found.y) else found.y
    if found.y_events is not None:
        found.y_events = [one[:, :n] if one.ndim == 2 else one for one in found.y_events]
    if found.sol is not None:
        sol = found.sol
        found.sol = PiecewisePolynomial(sol.ts, sol.polynomials[:, :, :n], sol.spans)
    return found


class RubbingResult(SystemResult):
    """A SystemResult with `phases`, a list of (name, start, end)."""

    phases: Any
    ways: Any

    def quantities(self):
        """As of any system, each phase by its own equations."""
        return self.at_points(self.system.quantities, slice(None))

    def at_points(self, names, points):
        """Quantities of some names at some points of the run."""
        t = self.t[points]
        y = np.asarray(self.y)[:, points]
        found = {name: np.empty(len(t)) for name in names}
        first = np.searchsorted([begin for _, begin, _ in self.phases[1:]], t, side="left")
        modes = [self.system.mode(ways) for ways in self.ways]
        for mode in set(modes):
            functions = mode.quantities
            here = np.isin(first, [n for n, one in enumerate(modes) if one is mode])
            for name in found:
                found[name][here] = self.system.along(functions[name], t[here], y[:, here])
        return found
