"""The server of the page, on this machine alone."""

import asyncio
import contextlib
import html
import socket
from typing import Any

import panel as pn

from .exploration import Exploration
from .page import WRONG, Page
from .sources import known, named

ADDRESS = "127.0.0.1"


def application(source):
    """The function that makes the page of one visitor: a choice of systems, and the page."""

    def made():
        names = known()
        if source.name not in names:
            names = [source.name, *names]
        choice = pn.widgets.Select(name="system", options=names, value=source.name, width=320)
        place = pn.Column(Page(source).panel())

        async def chosen(event):
            periodic: Any = pn.state._periodic
            for callback in list(periodic.get(pn.state.curdoc, ())):
                callback.stop()
            place[:] = [pn.pane.Alert(f"{event.new} is being made ...", alert_type="info")]
            try:
                taken = await asyncio.to_thread(ready, source, event.new)
            except WRONG as error:
                place[:] = [pn.pane.Alert(html.escape(str(error)), alert_type="danger")]
                return
            if choice.value == event.new:  # nothing else was chosen meanwhile
                place[:] = [Page(taken).panel()]

        choice.param.watch(chosen, "value")
        return pn.Column(choice, place)

    return made


def ready(first, name):
    """The source of a system by its name, derived and compiled."""
    source = first if name == first.name else named(name)
    with contextlib.suppress(*WRONG):  # of a start that cannot be solved: the page says so
        Exploration(source).solve()
    return source


def serve(source, port=0, show=True, threaded=False):
    """
    Serve the page of a system, and of all others that it lets choose.

    Parameters
    ----------
    source : Source
        What is shown first.
    port : int
        0 for one that is free.
    show : bool
        Whether to open a browser.
    threaded : bool
        Whether to return at once; else the call ends with Ctrl-C.

    Returns
    -------
    (str, server)
        The address, and what has a method `stop`.
    """
    port = port or free_port()
    print(f"http://{ADDRESS}:{port} shows {source.make.title}; Ctrl-C ends.", flush=True)
    server = pn.serve(
        application(source), port=port, address=ADDRESS, show=show, threaded=threaded,
        title="fastdyn explore", verbose=False,
        websocket_origin=[f"{ADDRESS}:{port}", f"localhost:{port}"],
    )  # fmt: skip
    return f"http://{ADDRESS}:{port}", server


def free_port():
    """A port that nobody listens on."""
    with socket.socket() as one:
        one.bind((ADDRESS, 0))
        return one.getsockname()[1]
