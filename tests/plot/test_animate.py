"""Moving pictures."""

import pytest

from fastdyn.systems import SYSTEMS, cable, suspension


def test_moving_pictures(tmp_path):
    run = cable(V0=5.9).solve((0.0, 2.0))
    for name in ("cable.gif", "cable.html"):
        run.animate(tmp_path / name, seconds=0.3, fps=10)
        assert (tmp_path / name).stat().st_size > 1000
    for name in ("satellite", "building", "vehicle", "rod"):
        system = SYSTEMS[name]()
        system.solve((0.0, 1.0)).animate(tmp_path / f"{name}.gif", seconds=0.2, fps=10)
        assert (tmp_path / f"{name}.gif").read_bytes().startswith(b"GIF8")
    with pytest.raises(ValueError, match=r"a \.gif or an \.html file"):
        run.animate(tmp_path / "cable.mp3")
    with pytest.raises(ValueError, match="no view to animate"):
        suspension().solve((0.0, 1.0)).animate(tmp_path / "x.gif")
