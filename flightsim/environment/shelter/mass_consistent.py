"""The flow nearest to a first guess that neither piles up anywhere nor enters solids.

    symbol   name
    v_0, v   velocity of the guess and of the result, on the faces of cells
    l        multiplier, in the middle of cells, 0 beyond the open borders

    minimise  sum (v - v_0)^2  with  div v = 0:   v = v_0 + grad l,   div grad l = -div v_0

Faces of solids and of the ground let nothing through, for which the gradient across them is zero.
Without a lee in the guess the result is a potential flow.

Source: Sherman 1978, "A mass-consistent model for wind fields over complex terrain", section 2,
with equal weights of horizontal and vertical changes.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from jaxtyping import Bool, Float

_TOLERANCE = 1e-5  # relative, of the residual's norm
_MOST_ITERATIONS = 2000

Faces = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Velocities across the faces of cells along x, y, z: one more along each's own axis than cells."""


def mass_consistent(
    guess: Float[np.ndarray, "nx ny nz 3"], is_solid: Bool[np.ndarray, "nx ny nz"]
) -> Float[np.ndarray, "nx ny nz 3"]:
    """Adjust a field in the middle of cells over flat ground, its sides and top open.

    Args:
        guess: First guess of the velocity.
        is_solid: Cells that nothing flows through.

    Returns:
        Velocity in the middle of cells; the mean of both faces along each axis.
    """
    faces = _faces(guess, is_solid)
    multiplier = _solve(is_solid, _divergence(faces))
    for axis in range(3):
        gradient = np.diff(_padded(multiplier, axis), axis=axis)
        np.add(faces[axis], gradient * _is_open(is_solid, axis), out=faces[axis])
    middle = [
        0.5 * (_cut(f, i, slice(1, None)) + _cut(f, i, slice(-1))) for i, f in enumerate(faces)
    ]
    return np.stack(middle, axis=-1)


def _cut(array: np.ndarray, axis: int, part: slice) -> np.ndarray:
    return array[(slice(None),) * axis + (part,)]


def _padded(array: np.ndarray, axis: int, value: float = 0.0) -> np.ndarray:
    """Return the array with a cell of this value at both ends of an axis."""
    width = [(1, 1) if i == axis else (0, 0) for i in range(3)]
    return np.pad(array, width, constant_values=value)


def _is_open(is_solid: np.ndarray, axis: int) -> np.ndarray:
    """Faces across an axis that no solid touches; the ground's are shut."""
    shut = _padded(is_solid, axis, value=False)
    is_open = ~(_cut(shut, axis, slice(1, None)) | _cut(shut, axis, slice(-1)))
    if axis == 2:
        is_open[:, :, 0] = False
    return is_open


def _faces(guess: np.ndarray, is_solid: np.ndarray) -> Faces:
    """Velocities across faces: means of both sides, the cell's own at the border, 0 if shut."""
    x, y, z = (
        0.5
        * (_cut(wide, axis, slice(1, None)) + _cut(wide, axis, slice(-1)))
        * _is_open(is_solid, axis)
        for axis in range(3)
        for wide in [np.pad(guess[..., axis], _edge(axis), mode="edge")]
    )
    return x, y, z


def _edge(axis: int) -> list[tuple[int, int]]:
    return [(1, 1) if i == axis else (0, 0) for i in range(3)]


def _divergence(faces: Faces) -> np.ndarray:
    x, y, z = (np.diff(face, axis=axis) for axis, face in enumerate(faces))
    return x + y + z


def _solve(is_solid: np.ndarray, divergence: np.ndarray) -> np.ndarray:
    """Multiplier of the divergence, times the edge of a cell."""
    from scipy import sparse

    n = is_solid.size
    index = np.arange(n).reshape(is_solid.shape)
    diagonal = np.zeros(is_solid.shape)
    rows, columns = [], []
    for axis in range(3):
        is_open = _is_open(is_solid, axis)
        # A cell's own weight is the number of its open faces; neighbours beyond the border are 0.
        diagonal += _cut(is_open, axis, slice(1, None)).astype(float)
        diagonal += _cut(is_open, axis, slice(-1))
        inner = _cut(is_open, axis, slice(1, -1))
        rows.append(_cut(index, axis, slice(-1))[inner])
        columns.append(_cut(index, axis, slice(1, None))[inner])
    row, column = np.concatenate(rows), np.concatenate(columns)
    # Enclosed cells, such as those of solids, have no equation: they stay 0.
    diagonal[diagonal == 0.0] = 1.0
    off = sparse.coo_array((-np.ones(len(row)), (row, column)), shape=(n, n)).tocsr()
    matrix = sparse.diags_array(diagonal.ravel()) + off + off.T
    solution = _conjugate_gradients(matrix, divergence.ravel(), 1.0 / diagonal.ravel())
    return solution.reshape(is_solid.shape)


def _conjugate_gradients(
    matrix: Any, right: Float[np.ndarray, " n"], inverse_diagonal: Float[np.ndarray, " n"]
) -> Float[np.ndarray, " n"]:
    """Solve a symmetric system, to the same bits however many threads BLAS has.

    SciPy's `cg` takes dot products by BLAS, whose order of summation depends on the number of its
    threads: one seed would be several flights in wind.
    """
    solution, residual = np.zeros_like(right), right.copy()
    least = (_TOLERANCE**2) * np.sum(right * right)
    direction, before = np.zeros_like(right), 1.0
    for _ in range(_MOST_ITERATIONS):
        if np.sum(residual * residual) <= least:
            break
        # Jacobi preconditioner: the diagonal alone.
        preconditioned = inverse_diagonal * residual
        now = np.sum(residual * preconditioned)
        direction = preconditioned + (now / before) * direction
        image = matrix @ direction
        step = now / np.sum(direction * image)
        solution += step * direction
        residual -= step * image
        before = now
    return solution
