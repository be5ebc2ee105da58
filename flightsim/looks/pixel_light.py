"""Light for every pixel of a fine picture, by rays: soft shadows, sky, and light that bounces.

Each pixel asks the sun (a small disc, so that shadows blur with distance) and some directions of
its hemisphere: what gets out meets the sky, what ends on something near gets little, on something
far the light that is about everywhere, out of doors or from lamps in a room. Rays of neighbouring
pixels differ, and a filter that keeps edges takes the grain away.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from flightsim.looks.light import SUN_DIRECTION
from flightsim.looks.mesh import WorldMesh
from flightsim.looks.rays import NOTHING, RayScene

_TO_SUN = -np.array(SUN_DIRECTION, dtype=np.float32)
_SUN_RGB = np.array([1.04, 0.97, 0.85], dtype=np.float32)
_SUN_SPREAD = 0.012
"""Radius of the sun's disc, rad: some three times the real one's, for softer edges."""
_ZENITH_RGB = np.array([0.36, 0.42, 0.52], dtype=np.float32)
_LEVEL_RGB = np.array([0.52, 0.53, 0.54], dtype=np.float32)
"""Light that comes from the sky, above and near the horizon."""
_LAMP_RGB = np.array([1.22, 1.16, 1.04], dtype=np.float32)
"""Light that comes from lamps, and from ceilings, which have them all over."""
_LEAST_ON_LAMPS = 0.9
_BOUNCE_RGB = np.array([0.58, 0.55, 0.50], dtype=np.float32)
_BOUNCE_REACH_M = 1.3
"""Light that comes off things about as far as this is dimmed to two thirds."""
_LIFT = 0.78
"""Exponent that opens the shadows."""
_SHOULDER, _BRIGHTEST = 0.78, 1.02
"""Light above the shoulder is squeezed below the brightest."""
_N_SKY_RAYS = 5
_OFF_SURFACE = 1.5e-3
"""Rays start this far before the surface, in shares of the distance from the eye, ..."""
_OFF_SURFACE_M = 0.004
"""... and at least this far, m."""
_BAND_ROWS = 96
_DEPTH_TOLERANCE = 0.03
_STEPS = (1, 2, 4)
"""Spacing of the filter's taps, pixels."""


@dataclass(frozen=True, eq=False)
class Seen:
    """What rays from the eye meet, one for each pixel."""

    has_surface: Bool[np.ndarray, "h w"]
    depth_m: Float[np.ndarray, "h w"]
    rgb: Float[np.ndarray, "h w 3"]
    """Light on the surface, factors of its colour."""
    triangle: np.ndarray
    """(h, w) int; which of the mesh's, or more than it has for the vehicle's."""


class PixelLight:
    """Lights what a mesh and a vehicle in it show to an eye."""

    def __init__(self, mesh: WorldMesh) -> None:
        self._corners = mesh.corners_enu_m().astype(np.float32)
        self._normals = mesh.normals_enu[mesh.triangles].astype(np.float32)
        self._is_clear = mesh.is_clear()
        self._is_lamp = mesh.is_lamp()

    def light(self, eye_enu_m: np.ndarray, rays_enu: np.ndarray, vehicle_enu_m: np.ndarray) -> Seen:
        """Light along rays.

        Args:
            eye_enu_m: (3,).
            rays_enu: (h, w, 3), one metre deep.
            vehicle_enu_m: (t, 3, 3), triangles that move about in the mesh.
        """
        rng = np.random.default_rng(0x11)
        across = np.cross(
            vehicle_enu_m[:, 1] - vehicle_enu_m[:, 0], vehicle_enu_m[:, 2] - vehicle_enu_m[:, 0]
        )
        across = across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-12)
        corners = np.concatenate([self._corners, vehicle_enu_m]).astype(np.float32)
        normals = np.concatenate([self._normals, np.repeat(across[:, None], 3, axis=1)])
        is_clear = np.concatenate([self._is_clear, np.zeros(len(vehicle_enu_m), dtype=bool)])
        is_lamp = np.concatenate([self._is_lamp, np.zeros(len(vehicle_enu_m), dtype=bool)])
        seen = RayScene(corners)
        solid = _Surroundings(RayScene(corners[~is_clear]), is_lamp[~is_clear])
        shape = rays_enu.shape[:2]
        depth = np.full(shape, np.inf, dtype=np.float32)
        triangle = np.full(shape, NOTHING)
        normal = np.zeros((*shape, 3), dtype=np.float32)
        rgb, sun = np.zeros((*shape, 3), np.float32), np.zeros(shape, np.float32)
        eye = eye_enu_m.astype(np.float32)
        for top in range(0, shape[0], _BAND_ROWS):
            band = slice(top, top + _BAND_ROWS)
            rays = rays_enu[band].reshape(-1, 3)
            hits = seen.first_hits(np.broadcast_to(eye, rays.shape), rays)
            met = np.flatnonzero(hits.triangle != NOTHING)
            own = hits.triangle[met]
            weights = np.stack([1 - hits.u - hits.v, hits.u, hits.v], axis=1)[met]
            facing = np.einsum("nki,nk->ni", normals[own], weights)
            facing /= np.maximum(np.linalg.norm(facing, axis=1, keepdims=True), 1e-6)
            points = eye + hits.distance[met, None] * rays[met]
            off = np.maximum(_OFF_SURFACE_M, _OFF_SURFACE * hits.distance[met])[:, None]
            starts = points + off * facing
            light = _scattered(solid, starts, facing, rng)
            light[is_lamp[own]] = np.maximum(light[is_lamp[own]], _LEAST_ON_LAMPS)
            for array, values in (
                (rgb, light),
                (normal, facing),
                (sun[..., None], _direct(solid, starts, facing, rng)[:, None]),
            ):
                array[band].reshape(len(rays), -1)[met] = values
            depth[band] = hits.distance.reshape(depth[band].shape)
            triangle[band] = hits.triangle.reshape(depth[band].shape)
        same = _Neighbours(depth, normal)
        light_rgb = same.averaged(rgb, _STEPS) + same.averaged(sun[..., None], (1,)) * _SUN_RGB
        return Seen(triangle != NOTHING, depth, _exposed(light_rgb), triangle)


@dataclass(frozen=True, eq=False)
class _Surroundings:
    """What light comes from or is stopped by."""

    rays: RayScene
    is_lamp: np.ndarray
    """(t,) bool."""


def _direct(
    around: _Surroundings, points: np.ndarray, normals: np.ndarray, rng: np.random.Generator
) -> np.ndarray:
    """(n,): sun on points, by one ray each to somewhere on its disc."""
    cosine = normals @ _TO_SUN
    ahead = np.flatnonzero(cosine > 0)
    spread = rng.standard_normal((len(ahead), 3), dtype=np.float32) * _SUN_SPREAD
    sun = np.zeros(len(points), dtype=np.float32)
    is_hidden = around.rays.is_hidden(points[ahead], _TO_SUN + spread)
    sun[ahead] = np.where(is_hidden, 0.0, cosine[ahead])
    return sun


def _scattered(
    around: _Surroundings, points: np.ndarray, normals: np.ndarray, rng: np.random.Generator
) -> np.ndarray:
    """(n, 3): light on points from everywhere but the sun, with the grain of few rays."""
    n = len(points)
    rgb = np.zeros((n, 3), dtype=np.float32)
    turn = rng.random(n, dtype=np.float32)
    u, v = _tangents(normals)
    for k in range(_N_SKY_RAYS):
        share = (k + rng.random(n, dtype=np.float32)) / _N_SKY_RAYS
        angle = 2 * np.pi * (turn + k * 0.618034)
        x, y = np.sqrt(share) * np.cos(angle), np.sqrt(share) * np.sin(angle)
        height = np.sqrt(1.0 - share)
        rays = x[:, None] * u + y[:, None] * v + height[:, None] * normals
        hits = around.rays.first_hits(points, rays)
        up = np.clip(rays[:, 2:], 0.0, 1.0)
        sky = _LEVEL_RGB + up * (_ZENITH_RGB - _LEVEL_RGB)
        near = 1.0 - np.exp(-np.minimum(hits.distance, 50.0) / _BOUNCE_REACH_M)
        from_things = near[:, None] * _BOUNCE_RGB
        from_things[around.is_lamp[hits.triangle]] = _LAMP_RGB
        is_free = (hits.triangle == NOTHING)[:, None]
        rgb += np.where(is_free, sky, from_things) / _N_SKY_RAYS
    return rgb


def _tangents(normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors across each normal and each other."""
    x, y, z = normals.T
    # Continuous but for straight down (Duff and others 2017, "Building an orthonormal basis").
    sign = np.where(z >= 0, np.float32(1), np.float32(-1))
    a = -1 / (sign + z)
    b = x * y * a
    u = np.stack([1 + sign * x * x * a, sign * b, -sign * x], axis=1)
    v = np.stack([b, sign + y * y * a, -y], axis=1)
    return u, v


def _exposed(light_rgb: np.ndarray) -> np.ndarray:
    """Shadows opened, and white held back from glaring."""
    lifted = light_rgb**_LIFT
    over = np.maximum(0.0, lifted - _SHOULDER)
    room = _BRIGHTEST - _SHOULDER
    return np.minimum(lifted, _SHOULDER) + room * (1.0 - np.exp(-over / room))


class _Neighbours:
    """Averages over neighbouring pixels that show the same surface."""

    def __init__(self, depth_m: np.ndarray, normals: np.ndarray) -> None:
        self._depth_m = np.where(np.isfinite(depth_m), depth_m, 1e6)
        self._normals = normals

    def averaged(self, light: np.ndarray, steps: tuple[int, ...]) -> np.ndarray:
        """Light, (h, w, c), without grain; each step widens the average."""
        for step in steps:
            total = light.copy()
            weight = np.ones(light.shape[:2], dtype=np.float32)
            for down, right in ((0, 1), (1, 0), (1, 1), (1, -1)):
                self._add(total, weight, light, down * step, right * step)
            light = total / weight[..., None]
        return light

    def _add(
        self, total: np.ndarray, weight: np.ndarray, light: np.ndarray, down: int, right: int
    ) -> None:
        """Add pixels at a shift and at its opposite."""
        height, width = weight.shape
        here = (slice(0, height - down), slice(max(0, -right), width - max(0, right)))
        there = (slice(down, height), slice(max(0, right), width + min(0, right)))
        depth_m, normals = self._depth_m, self._normals
        nearer = np.minimum(depth_m[here], depth_m[there])
        alike = np.abs(depth_m[here] - depth_m[there]) < _DEPTH_TOLERANCE * nearer
        alike &= np.einsum("hwi,hwi->hw", normals[here], normals[there]) > 0.9
        share = alike[..., None].astype(np.float32)
        total[here] += share * light[there]
        total[there] += share * light[here]
        weight[here] += share[..., 0]
        weight[there] += share[..., 0]
