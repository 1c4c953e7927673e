"""All systems as pages of a static site, with an index."""

import html
from pathlib import Path

from fastdyn.explore.sources import known, named

from .html import page

INDEX = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<link rel="icon" href="data:,">
<title>Equations of motion, to try</title>
<style>
body { font: 17px/1.5 system-ui, sans-serif; max-width: 42rem; margin: 0 auto; padding: 12px; }
li { margin: 6px 0; } a { color: #0072b2; } small { color: #666; }
</style>
</head>
<body>
<h1>Equations of motion, to try</h1>
<p>Each page is one file, which solves in your browser and needs no network: save the page to take
it along.</p>
<ul>
%s
</ul>
</body>
</html>
"""


def build(folder, names=None, say=print):
    """
    Write pages and ``index.html`` into a folder.

    Parameters
    ----------
    folder : path
    names : list of str, optional
        By default all systems of the course, and all models of `fastdyn.derive.pages`.
    say : callable
        Called with a sentence for each page, and for each system that is left out.

    Returns
    -------
    list of Path
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    items = []
    for name in known() if names is None else names:
        try:
            source = named(name)
            system = source.make(**source.values)
            text = page(system)
        except ValueError as error:
            say(f"{name} is left out: {error}")
            continue
        path = folder / f"{name}.html"
        path.write_text(text, encoding="utf-8")
        say(f"{path} ({len(text.encode()) / 1000:.0f} kB)")
        written.append(path)
        items.append(
            f'<li><a href="{name}.html">{html.escape(system.title)}</a> '
            f"<small>{html.escape(system.source)}</small></li>"
        )
    index = folder / "index.html"
    index.write_text(INDEX % "\n".join(items), encoding="utf-8")
    return [*written, index]
