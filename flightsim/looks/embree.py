"""Embree from compiled code: triangles, and packets of 16 rays, through its C interface.

embreex brings the library. Its own calls take one ray at a time; a packet of the rays of an image
costs a third, and finds the same hits to the bit.

    rows of a packet   meaning, 16 numbers each (`RTCRayHit16` of Embree 4)
    0 to 2             origin
    3, 7, 9, 10, 11    least distance, time, mask, number, flags
    4 to 6             direction
    8                  greatest distance; then that of the hit
    12 to 14           normal of the triangle
    15, 16             barycentric weights of its second and third corner
    17 to 20           numbers of triangle, mesh, instance and instance in an array
"""

from __future__ import annotations

import ctypes
import functools
import inspect
import weakref
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from autonomy.jit import kernel

LANES = 16
"""Rays in a packet."""
RAY_ORIGIN, RAY_DIRECTION, RAY_FAR, RAY_MASK, HIT_U, HIT_V, HIT_TRIANGLE, HIT_MESH = (
    *(0, 4, 8, 9),
    *(15, 16, 17, 18),
)
"""Rows of a packet."""
COHERENT = 1 << 16
"""Flag of packets whose rays begin at one point and point nearly alike."""
NO_MESH = -1
_N_ROWS, _ALIGNED_BYTES = 21, 64
_TRIANGLES, _INDICES, _VERTICES, _UINT3, _FLOAT3, _ROBUST = 0, 0, 1, 0x5003, 0x9003, 4
"""Constants of `RTCGeometryType`, `RTCBufferType`, `RTCFormat` and `RTCSceneFlags`."""
# The features are the upper half of the first field of the arguments.
_ALL_FEATURES = -1 << 32
_POINTER = ir.IntType(8).as_pointer()


class EmbreeError(RuntimeError):
    """Embree refuses to work on this machine."""


class Functions(NamedTuple):
    """Addresses of functions in the library, for kernels."""

    intersect: int
    """`rtcIntersect16`."""
    occluded: int
    """`rtcOccluded16`."""


@functools.cache
def functions() -> Functions:
    """Return the addresses of the functions that kernels call."""
    library = _library()
    addresses = (
        ctypes.cast(function, ctypes.c_void_p).value
        for function in (library.rtcIntersect16, library.rtcOccluded16)
    )
    return Functions(*(address or 0 for address in addresses))


class TriangleScene:
    """Triangles prepared for rays, in Embree's memory.

    Attributes:
        address: `RTCScene`, for kernels; they may use it while this object lives.
    """

    def __init__(self, triangles_m: np.ndarray) -> None:
        """Prepare triangles.

        Args:
            triangles_m: Corners (t, 3, 3), at least one triangle.
        """
        library, corners = _library(), np.ascontiguousarray(triangles_m, dtype=np.float32)
        self.address: int = library.rtcNewScene(_device())
        library.rtcSetSceneFlags(self.address, _ROBUST)
        mesh, n = library.rtcNewGeometry(_device(), _TRIANGLES), len(corners)
        numbers = np.arange(3 * n, dtype=np.uint32)
        for kind, form, array, rows in (
            (_VERTICES, _FLOAT3, corners, 3 * n),
            (_INDICES, _UINT3, numbers, n),
        ):
            # 12 bytes a row: three floats or three numbers of vertices.
            place = library.rtcSetNewGeometryBuffer(mesh, kind, 0, form, 12, rows)
            ctypes.memmove(place, array.ctypes.data, array.nbytes)
        library.rtcCommitGeometry(mesh)
        library.rtcAttachGeometry(self.address, mesh)
        # The scene holds the geometry from now on.
        library.rtcReleaseGeometry(mesh)
        library.rtcCommitScene(self.address)
        # Released with this object, never while a kernel may use the address.
        weakref.finalize(self, library.rtcReleaseScene, self.address)


@functools.cache
def _library() -> ctypes.CDLL:
    """Load Embree by way of embreex, which links to it: a look-up there finds its symbols too."""
    # Load it only when someone casts a ray.
    from embreex.rtcore_scene import EmbreeScene

    library = ctypes.CDLL(inspect.getfile(EmbreeScene))
    pointer, integer, size = ctypes.c_void_p, ctypes.c_uint, ctypes.c_size_t
    for name, result, arguments in (
        ("rtcNewDevice", pointer, [pointer]),
        ("rtcNewScene", pointer, [pointer]),
        ("rtcSetSceneFlags", None, [pointer, integer]),
        ("rtcNewGeometry", pointer, [pointer, integer]),
        ("rtcSetNewGeometryBuffer", pointer, [pointer, *[integer] * 3, size, size]),
        ("rtcCommitGeometry", None, [pointer]),
        ("rtcAttachGeometry", integer, [pointer, pointer]),
        ("rtcReleaseGeometry", None, [pointer]),
        ("rtcCommitScene", None, [pointer]),
        ("rtcReleaseScene", None, [pointer]),
    ):
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library


@functools.cache
def _device() -> int:
    # Created once and kept for all scenes.
    device = _library().rtcNewDevice(None)
    if not device:
        raise EmbreeError("Embree finds no device; valid: a processor with SSE2 or NEON")
    return device


# A kernel calls what this decorates without the first argument, which no type checker can know.
_in_kernel: Any = intrinsic


@_in_kernel
def call_rtc_packet(
    _typing: Any, _function: Any, _valid: Any, _scene: Any, _packet: Any, _arguments: Any
) -> Any:
    """Call `void rtcIntersect16(valid, scene, rayhit, args)` or its sister; pointers are integers.

    The function's address is an argument, because it differs from run to run, and compiled code is
    cached.
    """
    signature = types.void(*[types.intp] * 5)

    def codegen(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        cast = ir.FunctionType(ir.VoidType(), [_POINTER] * 4)
        target = builder.inttoptr(args[0], cast.as_pointer())
        builder.call(target, [builder.inttoptr(arg, _POINTER) for arg in args[1:]])
        return context.get_dummy_value()

    return signature, codegen


@kernel
def new_packet() -> np.ndarray:
    """Return a packet (21, 16) of float32, aligned as Embree demands, of rays from 0 on."""
    n, spare = _N_ROWS * LANES, _ALIGNED_BYTES // 4
    room = np.zeros(n + spare, np.float32)
    # Number of floats up to the next multiple of 64 bytes.
    first = -room.ctypes.data % _ALIGNED_BYTES // 4
    packet = room[first : first + n].reshape(_N_ROWS, LANES)
    packet.view(np.int32)[RAY_MASK] = -1
    return packet


@kernel
def new_valid() -> np.ndarray:
    """Return the mask of a packet's rays (16,): -1 casts a ray, 0 does not; aligned likewise."""
    room = np.zeros(LANES + _ALIGNED_BYTES // 4, np.int32)
    first = -room.ctypes.data % _ALIGNED_BYTES // 4
    return room[first : first + LANES]


@kernel
def new_arguments(flags: int) -> np.ndarray:
    """Return `RTCIntersectArguments` without callbacks, as integers."""
    arguments = np.zeros(5, np.int64)
    arguments[0] = _ALL_FEATURES | flags
    return arguments
