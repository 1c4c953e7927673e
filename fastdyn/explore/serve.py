"""The server of the page, on this machine alone."""

import socket
from typing import Any

import panel as pn

from .page import Page
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

        def chosen(event):
            periodic: Any = pn.state._periodic
            for callback in list(periodic.get(pn.state.curdoc, ())):
                callback.stop()
            taken = source if event.new == source.name else named(event.new)
            place[:] = [Page(taken).panel()]

        choice.param.watch(chosen, "value")
        return pn.Column(choice, place)

    return made


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
