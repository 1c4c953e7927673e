"""The types of the arguments of the kernels for boundary value problems."""

from fastdyn.kernels.stepping.collocation import Functions, Mesh, Room

from . import CUBE, ROW, TABLE, WORDS, kernel_of

OF_MESH = (
    Functions(WORDS, WORDS, WORDS, WORDS, TABLE, TABLE, TABLE),
    Mesh(ROW, TABLE, ROW),
    Room(
        *[ROW] * 8, *[TABLE] * 4, *[CUBE] * 4, ROW, WORDS, ROW, TABLE, ROW, TABLE, ROW, TABLE, ROW
    ),
)
NEWTON = kernel_of(*OF_MESH, 0.0, 0.0)
RESIDUALS = kernel_of(*OF_MESH, ROW)
