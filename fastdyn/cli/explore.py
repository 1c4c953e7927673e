"""The command that serves a page with sliders."""

from . import checks, find


def add_options(parser):
    """Teach a parser the system and the server."""
    parser.add_argument("system", nargs="?", default="satellite", metavar="SYSTEM",
                        help="of the course, derived, file.py or file.py:model")  # fmt: skip
    parser.add_argument("--port", type=checks.whole(0), default=0, metavar="N",
                        help="a free one unless given")  # fmt: skip
    parser.add_argument("--no-browser", action="store_true", help="only serve the page")


def run(options):
    from fastdyn.explore import NEEDED, sources

    word = options.system
    if word.endswith(".py") or ".py:" in word:
        source = sources.of_file(word, find.in_file(word))
    else:
        source = sources.named(word)
    try:
        from fastdyn.explore.serve import serve
    except ImportError:
        raise ValueError(NEEDED) from None
    serve(source, options.port, show=not options.no_browser)
    return 0
