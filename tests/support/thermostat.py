"""A thermostat: a room that cools, and a heater that two limits switch."""

from .impacts import marked


def heated(t, y, d, heat):
    return [-0.2 * (y[0] - 10.0) + heat * d[0]]


LOW = marked(lambda t, y, d, heat: y[0] - 19.0, direction=-1)
HIGH = marked(lambda t, y, d, heat: y[0] - 21.0, direction=1)
SWITCH = {
    "events": [LOW, HIGH],
    "on_event": [lambda t, y, d, heat: (y, [1.0]), lambda t, y, d, heat: (y, [0.0])],
}
