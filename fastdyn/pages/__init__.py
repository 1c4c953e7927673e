"""
A system as one file for a browser: it solves and draws there, without Python and network.

Curves have axes by uPlot, which is shipped in `assets/uplot`, with its licence. What was compared
(2026-11-28, minified):

======================  =======  ==========  ====================  ==========================
library                 kB       licence     touch                 phase planes
======================  =======  ==========  ====================  ==========================
uPlot 1.6.32            51       MIT         no gestures           paths of one's own
dygraphs 2.2.2          130      MIT         pinch, pan            no: a curve over sorted x
Chart.js 4.6.1          210      MIT         by a plugin           scatter with lines
ECharts 6.1.0, simple   500      Apache 2.0  pinch, pan            yes
Plotly 4.1.1, basic     1192     MIT         pinch, pan            yes
======================  =======  ==========  ====================  ==========================

A page has at most 400 kB, and draws its curves within a picture of the screen: uPlot. Handles for
fingers are the page's own, in all of these.
"""

from pathlib import Path


def write(system, file=None):
    """
    Write the page of a system; see `System.page`.

    Parameters
    ----------
    system : System
    file : path, optional

    Returns
    -------
    Path
    """
    from .html import page

    path = Path(f"{system.name}.html" if file is None else file)
    path.write_text(page(system), encoding="utf-8")
    return path
