"""A slider with a text field for its number."""

import math

import panel as pn
import param

from .grid import WIDTH

DIGITS = 10  # of a number that is shown


class _Quick(pn.widgets.FloatSlider):
    _debounce = 5  # milliseconds that Panel waits for further moves, else 50: 20 curves a second


class NumberSlider(pn.viewable.Viewer):
    """
    A slider that follows 30 times a second, and its number as text.

    Parameters
    ----------
    title : str
    value, start, end, step : float
        The range of the slider. If a typed number lies outside, the range grows.
    say : callable
        Called with a sentence if a typed text is no number, else with "".
    positive : bool
        Whether the number must be greater than zero.
    name : str
        Suffix of the CSS class of the slider, ``slider-name``.
    """

    value = param.Number()
    disabled = param.Boolean(False)

    def __init__(self, title, value, start, end, step, say, positive=False, name=""):
        super().__init__(value=value)
        self._title = title
        self._say = say
        self._positive = positive
        self.text = pn.widgets.TextInput(
            value=_shown(value),
            placeholder=title,
            width=85,
            margin=(0, 5),  # read to the blind
        )
        self.slider = _Quick(
            value=value, start=start, end=end, step=step, show_value=False, width=WIDTH,
            css_classes=[f"slider-{name}"],
        )  # fmt: skip
        self.text.param.watch(self._typed, "value")
        self.slider.param.watch(self._moved, "value")
        self.param.watch(self._follow, "value")
        self.param.watch(self._grey, "disabled")

    def __panel__(self):
        label = pn.widgets.StaticText(value=self._title, width=165, margin=(5, 10))
        return pn.Column(pn.Row(label, self.text, width=WIDTH + 20), self.slider, width=WIDTH + 20)

    def _typed(self, event):
        try:
            value = number(event.new)
        except ValueError as error:
            self._say(f"{self._title}: {error}")
            return
        if self._positive and value <= 0.0:
            self._say(f"{self._title} must be greater than zero; got {event.new}.")
            return
        self._say("")
        if _shown(self.value) != _shown(value):
            self.value = value

    def _moved(self, event):
        self.value = float(_shown(event.new))  # the browser's sums of steps end in noise

    def _grey(self, event):
        self.text.disabled = self.slider.disabled = event.new

    def _follow(self, event):
        if math.isfinite(event.new):
            ends = min(self.slider.start, event.new), max(self.slider.end, event.new)
            self.slider.param.update(start=ends[0], end=ends[1], value=event.new)
        self.text.value = _shown(event.new)


def number(text):
    """
    The finite number that a text represents.

    Raises
    ------
    ValueError
        With a sentence, also for a comma, because 1,500 is ambiguous.
    """
    try:
        value = float(text)
    except ValueError:
        advice = f"; with a point it is {text.replace(',', '.')}" if text.count(",") == 1 else ""
        raise ValueError(f"{text!r} is no number{advice}.") from None
    if not math.isfinite(value):
        raise ValueError(f"{text!r} is no finite number.")
    return value


def _shown(value):
    return f"{value:.{DIGITS}g}"
