"""MATLAB's odeEvent, and the properties of its objects: the parts of `ode_object`.

Names and meanings: MathWorks, reference page of odeEvent.
"""

import inspect
from typing import Any

import numpy as np

from fastdyn.compile.sentences import warn
from fastdyn.words import kinds
from fastdyn.words.near import did_you_mean

AS_OPTIONS = {
    "RelativeTolerance": "RelTol", "AbsoluteTolerance": "AbsTol", "MassMatrix": "Mass",
    "Jacobian": "Jacobian", "NonNegativeVariables": "NonNegative",
}  # fmt: skip
OLDER = {
    **{name.lower(): new for new, name in AS_OPTIONS.items()},
    "odefun": "ODEFcn", "y0": "InitialValue", "t0": "InitialTime", "events": "EventDefinition",
    "t": "Time", "x": "Time", "y": "Solution", "te": "EventTime", "ye": "EventSolution",
    "ie": "EventIndex",
}  # fmt: skip
DIRECTIONS = {"both": 0, "ascending": 1, "descending": -1}
RESPONSES = {"proceed": 0, "stop": 1, "callback": 1}  # whether the run ends
OF_EVENT = {"EventFcn": None, "Direction": "both", "Response": "proceed", "CallbackFcn": None}
ROUNDING = 4.0 * float(np.finfo(float).eps)  # of the time of an event, relative: the root's
PASSED = (
    "event {} at t = {:.6g} lies in the first step behind t = {:.6g}, where no event ends a run, "
    "as in MATLAB: its CallbackFcn is not called. A smaller MaxStep may help."
)


class Properties:
    """An object of MATLAB's: properties by name, each checked when it is set."""

    _called = ""
    _known: dict[str, Any]

    def __init__(self, **given):
        for name in given:
            if name not in self._known:
                raise TypeError(self._unknown(name))
        for name, default in self._known.items():
            vars(self)[name] = default
        for name, value in given.items():
            setattr(self, name, value)

    def __setattr__(self, name, value):
        if name not in self._known:
            raise AttributeError(self._unknown(name))
        vars(self)[name] = value if value is self._known[name] else self._checked(name, value)

    def __getattr__(self, name) -> Any:
        raise AttributeError(self._unknown(name))

    def __repr__(self):
        given = {n: v for n, v in vars(self).items() if v is not self._known[n]}
        given = {n: v for n, v in given.items() if not isinstance(v, dict) or v}
        return f"{self._called}({', '.join(f'{n}={v!r}' for n, v in given.items())})"

    def _unknown(self, name):
        meant = did_you_mean(name, self._known, OLDER, "{}")
        there = f"there are {', '.join(self._known)}."
        return f"`{self._called}` has no property `{name}`; {meant or there}"

    def _checked(self, name, value) -> Any:
        raise NotImplementedError


def one_of(name, value, known):
    """Texts of `known`, in any case; one text, or a list of texts."""
    texts = np.atleast_1d(np.asarray(value, object)).tolist()
    for text in texts:
        kinds.text(name, text)
        if text.lower() not in known:
            advice = did_you_mean(text, known, form="{!r}") or f"choose from {', '.join(known)}."
            raise ValueError(f"`{name}` has no choice {text!r}; {advice}")
    lower = [text.lower() for text in texts]
    return lower[0] if isinstance(value, str) else lower


class EventDefinition(Properties):
    """What `odeEvent` returns: the events of a problem, with its arguments as attributes."""

    _called = "odeEvent"
    _known = OF_EVENT

    def _checked(self, name, value):
        if name == "Direction":
            return one_of(name, value, DIRECTIONS)
        if name == "Response":
            return one_of(name, value, RESPONSES)
        kinds.function_of("(t, y)" if name == "EventFcn" else "(te, ye, ie)")(name, value)
        return value

    def events(self, t0, y0, p):
        """The function of (t, y) for the option Events, and the response to each event."""
        if self.EventFcn is None:
            raise ValueError("`odeEvent` needs EventFcn, a function of (t, y).")
        value = with_parameters(self.EventFcn, p)
        found = value(t0, y0.copy())
        count = np.size(found)
        responses = self._for_each("Response", count)
        if "callback" in responses and self.CallbackFcn is None:
            raise ValueError("`Response='callback'` needs CallbackFcn, a function of (te, ye, ie).")
        ends = [RESPONSES[one] for one in responses]
        signs = [DIRECTIONS[one] for one in self._for_each("Direction", count)]
        if np.ndim(found) == 0:
            return (lambda t, y: (value(t, y), ends[0], signs[0])), responses
        return (lambda t, y: (value(t, y), ends, signs)), responses

    def _for_each(self, name, count):
        given = getattr(self, name)
        if isinstance(given, list) and len(given) not in (1, count):
            raise ValueError(f"`{name}` is one text, or one for each of the {count} events.")
        given = [given] if isinstance(given, str) else given
        return given * count if len(given) == 1 else given

    def called_back(self, piece, responses, p):
        """Whether to stop at the end of a run, and the state and parameters to go on with."""
        end = piece.x[-1]
        y = piece.y[:, -1].copy()
        for i in piece.ie[piece.xe == end]:
            if responses[i] == "stop":
                return True, y, p
            if responses[i] == "callback":
                given = (end, y, int(i)) if p is None else (end, y, int(i), p)
                answer = self.CallbackFcn(*given)
                if not isinstance(answer, tuple | list) or len(answer) != len(given) - 1:
                    form = "stop, ye" if p is None else "stop, ye, p"
                    raise TypeError(f"`CallbackFcn` must return {form}; got {answer!r}.")
                y = np.ravel(answer[1])
                p = None if p is None else answer[2]
                if answer[0]:
                    return True, y, p
        return False, y, p


def with_parameters(function, p) -> Any:
    """`function` with p as its third argument, if it takes three; or as it is."""
    if p is None or not callable(function):
        return function
    try:
        inspect.signature(function).bind(None, None, p)
    except (TypeError, ValueError):
        return function
    return lambda t, y: function(t, y, p)


def see_to_first_step(piece, responses, goes_on):
    """Warn of events in the first step with a callback, which did not end the run.

    If the run goes on behind a callback, drop the zero from which it starts.
    """
    start = piece.x[0]
    at_start = abs(piece.xe - start) <= ROUNDING * abs(start)
    for te, i in zip(piece.xe[~at_start], piece.ie[~at_start], strict=True):
        if responses[i] == "callback" and te != piece.x[-1]:
            warn(PASSED.format(i, te, start))
    if goes_on:
        piece.xe = piece.xe[~at_start]
        piece.ye = piece.ye[:, ~at_start]
        piece.ie = piece.ie[~at_start]


def odeEvent(**properties) -> EventDefinition:
    """
    Events of an `ode`, as MATLAB's odeEvent.

    Parameters
    ----------
    EventFcn : callable
        ``EventFcn(t, y)`` or, with Parameters, ``EventFcn(t, y, p)`` returns a number or a list; an
        event is a zero of one of them.
    Direction : {"both", "ascending", "descending"} or list of these
        One for all events, or one for each.
    Response : {"proceed", "stop", "callback"} or list of these
        "callback" calls CallbackFcn and goes on with its state and parameters.
    CallbackFcn : callable
        ``stop, ye = CallbackFcn(te, ye, ie)``, with Parameters
        ``stop, ye, p = CallbackFcn(te, ye, ie, p)``; `ie` counts from 0.

    Returns
    -------
    EventDefinition

    Raises
    ------
    TypeError, ValueError
        For unknown names and choices, and values of another kind.

    Notes
    -----
    As in MATLAB, an event in the first step does not end a run; a callback that is passed over for
    this gets a warning.
    """
    return EventDefinition(**properties)
