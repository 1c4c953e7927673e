"""The command that writes a system as one file for a browser."""

from . import checks, find, functions


def add_options(parser):
    """Teach a parser the system, or the function, and the file."""
    parser.add_argument("what", nargs="?", metavar="SYSTEM",
                        help="of the course, derived, FILE.py, FILE.py:NAME, or FILE.py:FUNCTION, "
                        "fun(t, y, *args)")  # fmt: skip
    parser.add_argument("--all", action="store_true",
                        help="all systems, as a site with an index")  # fmt: skip
    parser.add_argument("--out", metavar="FILE", help="default SYSTEM.html; of --all a folder")
    functions.add_options(parser)
    parser.add_argument("--t-end", type=checks.positive, metavar="T",
                        help="end of the run of a function (s), default 10")  # fmt: skip


def run(options):
    """Write the page, or the site, and print the names of the files."""
    from fastdyn.pages import plain, site, write

    if options.all:
        if options.what:
            raise ValueError("give a system, or `--all`, not both.")
        site.build(options.out or "site")
        return 0
    if not options.what:
        raise ValueError("give a system, such as `fastdyn page pendulum`, or `--all`.")
    make = find.any_system(options.what)
    if make is not None:
        functions.refuse_words_of_functions(options)
        system = make(**getattr(make, "explored", {}))
    else:
        given = functions.given(options)
        t_end = options.t_end or plain.END
        system = plain.system_of(
            given.function, given.name, given.y0, given.args, given.events, t_end
        )
    print(write(system, options.out))
    return 0
