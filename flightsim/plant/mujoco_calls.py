"""MuJoCo's step, rays and arrays from inside a kernel, through their C pointers.

A kernel that steps ten times in one call saves nine trips through Python. Numba cannot call
MuJoCo's Python binding, but it can call a C function at an address. Addresses travel as integer
arguments. A kernel that is kept on disk must hold none of its own, because libraries load elsewhere
in the next process.
"""

from __future__ import annotations

import ctypes
import functools
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic
from numba.np.numpy_support import carray

from autonomy.jit import kernel

_POINTER = ir.IntType(8).as_pointer()


class EngineError(RuntimeError):
    """The installed MuJoCo has a memory layout that the kernels do not know."""


class Functions(NamedTuple):
    """Addresses in the library that `mujoco` has loaded."""

    step: int
    """Address of `mj_step`."""
    kinematics: int
    """Address of `mj_kinematics`."""
    ray_geom: int
    """Address of `mju_rayGeom`."""
    ray_mesh: int
    """Address of `mj_rayMesh`."""
    clock: int
    """Address of the variable `mjcb_time`, which points to the clock that times MuJoCo's stages; a
    null pointer in it means no clock."""


@functools.cache
def functions() -> Functions:
    """Return the addresses of the functions that kernels call."""
    folder = Path(mujoco.__file__).parent
    library = ctypes.CDLL(str(next(folder.glob("libmujoco.*"))))
    return Functions(
        step=_address(library.mj_step),
        kinematics=_address(library.mj_kinematics),
        ray_geom=_address(library.mju_rayGeom),
        ray_mesh=_address(library.mj_rayMesh),
        clock=ctypes.addressof(ctypes.c_void_p.in_dll(library, "mjcb_time")),
    )


def time_address(data: mujoco.MjData) -> int:
    """Return the address of the engine's clock in `mjData`, a double just before the energy.

    Raises:
        EngineError: If this version of MuJoCo keeps its clock elsewhere.
    """
    _check_time_address()
    return data.energy.ctypes.data - ctypes.sizeof(ctypes.c_double)


@functools.cache
def _check_time_address() -> None:
    data = mujoco.MjData(mujoco.MjModel.from_xml_string("<mujoco/>"))
    # The binding offers no address of `time`, so the place is tested with a known value.
    data.time = 0.25
    place = data.energy.ctypes.data - ctypes.sizeof(ctypes.c_double)
    if ctypes.c_double.from_address(place).value != data.time:
        raise EngineError(f"MuJoCo {mujoco.__version__} has its clock elsewhere; valid: 4.0")


def _address(function: Any) -> int:
    address = ctypes.cast(function, ctypes.c_void_p).value
    assert address is not None
    return address


# A kernel calls what this decorates without the first argument, which no type checker can know.
_in_kernel: Any = intrinsic


@_in_kernel
def call_engine(_typing: Any, _function: Any, _model: Any, _data: Any) -> Any:
    """Call `void mj_step(const mjModel* m, mjData* d)` or another function of the same type.

    The address of the function and both pointers are integers.
    """
    signature = types.void(types.intp, types.intp, types.intp)

    def codegen(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        function = ir.FunctionType(ir.VoidType(), [_POINTER, _POINTER])
        target = builder.inttoptr(args[0], function.as_pointer())
        builder.call(target, [builder.inttoptr(arg, _POINTER) for arg in args[1:]])
        return context.get_dummy_value()

    return signature, codegen


@_in_kernel
def call_mju_ray_geom(
    _typing: Any,
    _function: Any,
    _position: Any,
    _rotation: Any,
    _size: Any,
    _origin: Any,
    _direction: Any,
    _kind: Any,
) -> Any:
    """Call `mjtNum mju_rayGeom(pos, mat, size, pnt, vec, geomtype, normal)`, without a normal.

    Pointers are integers.
    """
    signature = types.float64(*[types.intp] * 6, types.intc)

    def codegen(_context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        parameters = [_POINTER] * 5 + [ir.IntType(32), _POINTER]
        ray = ir.FunctionType(ir.DoubleType(), parameters)
        target = builder.inttoptr(args[0], ray.as_pointer())
        places = [builder.inttoptr(arg, _POINTER) for arg in args[1:6]]
        return builder.call(target, [*places, args[6], ir.Constant(_POINTER, None)])

    return signature, codegen


@_in_kernel
def call_mj_ray_mesh(
    _typing: Any,
    _function: Any,
    _model: Any,
    _data: Any,
    _geom: Any,
    _origin: Any,
    _direction: Any,
) -> Any:
    """Call `mjtNum mj_rayMesh(m, d, geomid, pnt, vec, normal)`, without a normal.

    Pointers are integers.
    """
    signature = types.float64(*[types.intp] * 3, types.intc, *[types.intp] * 2)

    def codegen(_context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        parameters = [_POINTER, _POINTER, ir.IntType(32), *[_POINTER] * 3]
        ray = ir.FunctionType(ir.DoubleType(), parameters)
        target = builder.inttoptr(args[0], ray.as_pointer())
        m, d, pnt, vec = (builder.inttoptr(args[k], _POINTER) for k in (1, 2, 4, 5))
        return builder.call(target, [m, d, args[3], pnt, vec, ir.Constant(_POINTER, None)])

    return signature, codegen


@_in_kernel
def _pointer(_typing: Any, _address: Any) -> Any:
    def codegen(_context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        return builder.inttoptr(args[0], _POINTER)

    return types.voidptr(types.intp), codegen


@_in_kernel
def _add_one(_typing: Any, _address: Any) -> Any:
    def codegen(_context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        integer = ir.IntType(64)
        number = builder.inttoptr(args[0], integer.as_pointer())
        # "monotonic" suffices: threads share no data but the number itself.
        return builder.atomic_rmw("add", number, ir.Constant(integer, 1), "monotonic")

    return types.int64(types.intp), codegen


@kernel
def take_number(counter: np.ndarray) -> int:
    """Return the number in a counter (1,), int64, and count on; no two threads get the same."""
    return _add_one(counter.ctypes.data)


@kernel
def rows(address: int, n: int, dtype: Any) -> np.ndarray:
    """Return the n records of a type at an address, as a view."""
    return carray(_pointer(address), (n,), dtype)


@kernel
def doubles(address: int, n: int) -> np.ndarray:
    """Return the n doubles at an address, as a view."""
    return carray(_pointer(address), (n,), np.float64)


@kernel
def floats(address: int, n: int) -> np.ndarray:
    """Return the n floats of 32 bits at an address, as a view."""
    return carray(_pointer(address), (n,), np.float32)


@kernel
def table(address: int, n: int, columns: int) -> np.ndarray:
    """Return the n rows of doubles at an address, as a view."""
    return doubles(address, n * columns).reshape(n, columns)


@kernel
def integers(address: int, n: int) -> np.ndarray:
    """Return the n integers of 32 bits at an address, as a view."""
    return carray(_pointer(address), (n,), np.int32)


@kernel
def pointers(address: int, n: int) -> np.ndarray:
    """Return the n pointers at an address, as a view of integers."""
    return carray(_pointer(address), (n,), np.intp)


@kernel
def long_integers(address: int, n: int) -> np.ndarray:
    """Return the n integers of 64 bits at an address, as a view."""
    return carray(_pointer(address), (n,), np.int64)


@kernel
def bytes_at(address: int, n: int) -> np.ndarray:
    """Return the n bytes at an address, as a view."""
    return carray(_pointer(address), (n,), np.uint8)
