"""The server of the page, on this machine alone."""

import asyncio
import contextlib
import html
import logging
import socket
from typing import Any

import panel as pn
from tornado.websocket import WebSocketClosedError

from .exploration import Exploration
from .grid import WIDTH
from .layout import VIEWPORT
from .page import WRONG, Page
from .sources import known, named

ADDRESS = "127.0.0.1"


def application(source):
    """The function that makes the page of a visitor, with a choice of systems."""

    def made():
        names = known()
        if source.name not in names:
            names = [source.name, *names]
        choice = pn.widgets.Select(label="system", options=names, value=source.name, width=WIDTH)
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
            if choice.value == event.new:  # the visitor has not chosen another system meanwhile
                place[:] = [Page(taken).panel()]

        choice.param.watch(chosen, "value")
        return pn.Column(choice, place)

    return made


def ready(first, name):
    """The source of a system by its name, derived and compiled."""
    source = first if name == first.name else named(name)
    with contextlib.suppress(*WRONG):  # the page reports a start that cannot be solved
        Exploration(source).solve()
    return source


def _in_a_tab(made):
    """The function that makes a page, in a document of its own."""

    def opened():
        document: Any = pn.state.curdoc
        document.template = VIEWPORT
        asyncio.get_running_loop().set_exception_handler(_closed_tabs)
        return made()

    return opened


def _closed_tabs(loop, context):
    """Nothing is wrong where a picture was on its way to a tab that has been closed."""
    if not isinstance(context.get("exception"), WebSocketClosedError):
        loop.default_exception_handler(context)


def serve(source, port=0, show=True, threaded=False):
    """
    Serve the page of a system, on which other systems can be chosen.

    Parameters
    ----------
    source : Source
        The first system.
    port : int
        0 chooses a free port.
    show : bool
        Whether to open a browser.
    threaded : bool
        Whether to return at once; otherwise the call ends with Ctrl-C.

    Returns
    -------
    (str, server)
        The address, and the server, an object with a method `stop`.
    """
    port = port or free_port()
    # Bokeh warns of each picture that was on its way to a tab that has been closed.
    logging.getLogger("bokeh.server.views.ws").setLevel(logging.ERROR)
    print(f"http://{ADDRESS}:{port} shows {source.make.title}; Ctrl-C ends.", flush=True)
    server = pn.serve(
        _in_a_tab(application(source)), port=port, address=ADDRESS, show=show, threaded=threaded,
        title="fastdyn explore", verbose=False,
        websocket_origin=[f"{ADDRESS}:{port}", f"localhost:{port}"],
    )  # fmt: skip
    return f"http://{ADDRESS}:{port}", server


def free_port():
    """The number of a free port."""
    with socket.socket() as one:
        one.bind((ADDRESS, 0))
        return one.getsockname()[1]
