"""The whole tour, which takes seconds to draw and is looked at by more than one test."""

import contextlib
import io

import pytest

from fastdyn.cli.main import main
from fastdyn.course import tour


@pytest.fixture(scope="session")
def told(tmp_path_factory):
    """One run of the whole tour through the command line: status, text and board."""
    folder, boards, run = tmp_path_factory.mktemp("tour") / "figures", [], tour.run

    def noted(*given):
        boards.append(run(*given))
        return boards[0]

    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(io.StringIO()) as text:
        patch.setattr(tour, "run", noted)
        status = main(["tour", "--out", str(folder)])
    return status, text.getvalue(), boards[0]
