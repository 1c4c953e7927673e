"""The figures of a system's runs, and the picture of a system in one state."""

from typing import Any, ClassVar

import numpy as np

from .declare import of_instance


class Pictures:
    """The pictures of a `System`; subclasses replace `figure`, and `scene` if they have a view."""

    name: ClassVar[str]
    solve: Any

    def figure(self, results, **options):
        """
        Draw one result, or several for comparison.

        Parameters
        ----------
        results : dict of str to SystemResult
            Results by the label that the legend shows.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from fastdyn import plot

        return plot.components(results, **options)

    def scene(self, t, w) -> Any:
        """The picture of the system in one state, for moving pictures: a `plot.scene.Scene`."""
        raise ValueError(f"The {self.name} has no view to animate.")

    def stage(self, t, y) -> Any:
        """``scene(t, w)`` for the run with the times t and the columns of y."""
        return self.scene

    def scenes(self, t, y) -> list:
        """The scene of each column of y."""
        columns = zip(t, np.asarray(y).T, strict=True)
        scene = self.stage(t, y)
        return [scene(time, state) for time, state in columns]

    def at_start(self) -> Any:
        """The figure of the start; ValueError where nothing but points would be seen."""
        from fastdyn.plot import style
        from fastdyn.plot.animate import Artists

        system: Any = self
        scene = self.scene(0.0, np.array(system.initial_state(), float))
        if not (scene.lines or scene.bodies):
            raise ValueError(f"The {self.name} has no picture at its start.")
        with style.slides():
            artists = Artists([scene], trail=False)
            artists.show(0)
        return artists.figure

    @of_instance
    def explore(self) -> Any:
        """The page of `fastdyn explore` for this system, a Panel object that a notebook shows."""
        from fastdyn.explore import explore  # `explore` is built on systems, and so imported late

        return explore(self)

    @of_instance
    def page(self, file=None) -> Any:
        """
        Write the system as one file for a browser, with sliders, which needs nothing else.

        Parameters
        ----------
        file : path, optional
            By default the name of the system with ``.html``.

        Returns
        -------
        Path

        Raises
        ------
        ValueError
            If the equations have no form in JavaScript; the message names the line.
        """
        from fastdyn.pages import write  # pages are built on systems, and so imported late

        return write(self, file)

    @of_instance
    def animate(self, path=None, t_span: Any = None, **options) -> Any:
        """Solve, and show the motion; options as for `fastdyn.plot.animate.animate`."""
        return self.solve(t_span).animate(path, **options)

    @of_instance
    def plot(self, t_span: Any = None, ax=None, **options) -> Any:
        """Solve, and draw the run; options as for `solve`, `ax` as for `fastdyn.plot.plot`."""
        return self.solve(t_span, **options).plot(**{} if ax is None else {"ax": ax})
