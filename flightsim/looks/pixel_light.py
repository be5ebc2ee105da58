"""Ray-traced light for every pixel of a fine picture: soft shadows, sky and bounced light.

Each pixel casts rays to the sun (a small disc, so that shadows blur with distance) and in some
directions of its hemisphere: a ray that escapes gets the sky's light; one that hits something near
gets little, one that hits something far gets the ambient light outdoors or of lamps in a room.
Rays of neighbouring pixels differ, and an edge-preserving filter removes the grain.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from flightsim.looks.lamps import Lamps
from flightsim.looks.light import AFTERNOON, Light
from flightsim.looks.mesh import WorldMesh
from flightsim.looks.rays import NOTHING, RayScene

_SUN_RGB = np.array([1.04, 0.97, 0.85], dtype=np.float32)
"""Light of the afternoon's sun; this and the sky's light are scaled to other hours."""
_SUN_SPREAD = 0.012
"""Radius of the sun's disc, rad: three times the real one, for softer edges."""
_ZENITH_RGB = np.array([0.36, 0.42, 0.52], dtype=np.float32)
_LEVEL_RGB = np.array([0.52, 0.53, 0.54], dtype=np.float32)
"""Light from the sky, above and near the horizon."""
_LAMP_RGB = np.array([1.22, 1.16, 1.04], dtype=np.float32)
"""Light from lamps, and from ceilings, which have lamps all over."""
_LEAST_ON_LAMPS = 0.9
_BOUNCE_RGB = np.array([0.58, 0.55, 0.50], dtype=np.float32)
_BOUNCE_REACH_M = 1.3
"""Distance of objects at which the light from them is dimmed to two thirds."""
_LIFT = 0.78
"""Exponent that brightens the shadows."""
_SHOULDER, _BRIGHTEST = 0.78, 1.02
"""Light above the shoulder is compressed below the brightest value."""
_N_SKY_RAYS = 5
_OFF_SURFACE = 1.5e-3
"""Start of rays before the surface, as a share of the distance from the eye."""
_OFF_SURFACE_M = 0.004
"""Least start of rays before the surface, m."""
_BAND_ROWS = 96  # rows that are lit at a time, which bounds the memory
_DEPTH_TOLERANCE = 0.03  # relative difference of depth up to which neighbours show one surface
_STEPS = (1, 2, 4)
"""Spacing of the filter's taps in pixels."""


@dataclass(frozen=True, eq=False)
class Seen:
    """First hits of rays from the eye, one per pixel."""

    depth_m: Float[np.ndarray, "h w"]
    rgb: Float[np.ndarray, "h w 3"]
    """Light on the surface, as factors of its colour."""
    triangle: np.ndarray
    """Index (h, w) int in the mesh, or from the mesh's size on in the vehicle."""


class PixelLight:
    """Lights a view of a mesh and of a vehicle in it."""

    def __init__(
        self, mesh: WorldMesh, light: Light = AFTERNOON, lamps: Lamps | None = None
    ) -> None:
        """Prepare a mesh with true normals for the light of an hour, and for lamps at night."""
        self._sources, self._lamps = _Sources.of(light), lamps
        self._is_lit_within = np.array([paint.is_lit_within for paint in mesh.paints], dtype=bool)[
            mesh.triangle_paint
        ]
        self._corners = mesh.corners_enu_m().astype(np.float32)
        self._normals = mesh.normals_enu[mesh.triangles].astype(np.float32)
        self._is_clear = mesh.is_clear()
        self._is_lamp = mesh.is_lamp()

    def light(self, eye_enu_m: np.ndarray, rays_enu: np.ndarray, vehicle_enu_m: np.ndarray) -> Seen:
        """Return the light along rays.

        Args:
            eye_enu_m: Position of the eye (3,).
            rays_enu: Directions (h, w, 3), one metre deep.
            vehicle_enu_m: Triangles (t, 3, 3) that move in the mesh.
        """
        # A fixed seed: the same view is the same picture.
        rng = np.random.default_rng(0x11)
        across = np.cross(
            vehicle_enu_m[:, 1] - vehicle_enu_m[:, 0], vehicle_enu_m[:, 2] - vehicle_enu_m[:, 0]
        )
        across = across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-12)
        corners = np.concatenate([self._corners, vehicle_enu_m]).astype(np.float32)
        normals = np.concatenate([self._normals, np.repeat(across[:, None], 3, axis=1)])
        is_clear = np.concatenate([self._is_clear, np.zeros(len(vehicle_enu_m), dtype=bool)])
        is_lamp = np.concatenate([self._is_lamp, np.zeros(len(vehicle_enu_m), dtype=bool)])
        # The eye sees glass; light passes through it.
        seen = RayScene(corners)
        is_lit_within = np.append(self._is_lit_within, np.zeros(len(vehicle_enu_m), dtype=bool))
        solid = _Surroundings(RayScene(corners[~is_clear]), is_lamp[~is_clear], self._sources)
        shape = rays_enu.shape[:2]
        depth = np.full(shape, np.inf, dtype=np.float32)
        triangle = np.full(shape, NOTHING)
        normal = np.zeros((*shape, 3), dtype=np.float32)
        rgb, sun = np.zeros((*shape, 3), np.float32), np.zeros(shape, np.float32)
        eye = eye_enu_m.astype(np.float32)
        for top in range(0, shape[0], _BAND_ROWS):
            band = slice(top, top + _BAND_ROWS)
            rays = rays_enu[band].reshape(-1, 3)
            hits = seen.first_hits(eye, rays)
            met = np.flatnonzero(hits.triangle != NOTHING)
            own = hits.triangle[met]
            weights = np.stack([1 - hits.u - hits.v, hits.u, hits.v], axis=1)[met]
            facing = np.einsum("nki,nk->ni", normals[own], weights)
            facing /= np.maximum(np.linalg.norm(facing, axis=1, keepdims=True), 1e-6)
            points = eye + hits.distance[met, None] * rays[met]
            # Rounding of the hit grows with the distance.
            off = np.maximum(_OFF_SURFACE_M, _OFF_SURFACE * hits.distance[met])[:, None]
            starts = points + off * facing
            light = _scattered(solid, starts, facing, rng)
            light[is_lamp[own]] = np.maximum(light[is_lamp[own]], _LEAST_ON_LAMPS)
            if self._lamps is not None:
                light += self._lamps.light_at(starts, facing)[:, None] * self._sources.lamp_rgb
            sunlight = _direct(solid, starts, facing, rng)
            for array, values in (
                (rgb, light),
                (normal, facing),
                (sun[..., None], sunlight[:, None]),
            ):
                array[band].reshape(len(rays), -1)[met] = values
            depth[band] = hits.distance.reshape(depth[band].shape)
            triangle[band] = hits.triangle.reshape(depth[band].shape)
        same = _Neighbours(depth, normal)
        # The sun keeps its sharp shadows: its light is averaged over fewer pixels.
        sunlit = same.averaged(sun[..., None], (1,)) * self._sources.sun_rgb
        exposed = _exposed(same.averaged(rgb, _STEPS) + sunlit)
        # Triangle -1 is nothing; the last entry of the table stands for it.
        exposed[np.append(is_lit_within, False)[triangle]] = 1.0
        return Seen(depth, exposed, triangle)


@dataclass(frozen=True, eq=False)
class _Sources:
    """Colours of sun, sky, lamps and bounced light at an hour."""

    to_sun: np.ndarray
    sun_rgb: np.ndarray
    """Light of the sun; zero if it is hidden or down."""
    zenith_rgb: np.ndarray
    level_rgb: np.ndarray
    bounce_rgb: np.ndarray
    lamp_rgb: np.ndarray

    @classmethod
    def of(cls, light: Light) -> _Sources:
        """The afternoon's sources, scaled as the two colours of another light are to its own."""
        day = AFTERNOON
        sun = light.sun_share / day.sun_share * np.array(light.sun_rgb) / np.array(day.sun_rgb)
        sky = np.array(light.wall_rgb) / np.array(day.wall_rgb)
        level = np.array([[0.0, 0.0, 1.0]])
        lit = [each.rgb(each.surface(level, np.ones(1), np.ones(1)))[0] for each in (light, day)]
        rows = (
            (light.to_sun, 1.0),
            (_SUN_RGB, sun),
            (_ZENITH_RGB, sky),
            (_LEVEL_RGB, sky),
            (_BOUNCE_RGB, lit[0] / lit[1]),
            (np.array(light.sun_rgb), 1.0),
        )
        return cls(*((colour * factor).astype(np.float32) for colour, factor in rows))


@dataclass(frozen=True, eq=False)
class _Surroundings:
    """Geometry that emits or blocks light."""

    rays: RayScene
    is_lamp: np.ndarray
    """(t,) bool."""
    sources: _Sources


def _direct(
    around: _Surroundings, points: np.ndarray, normals: np.ndarray, rng: np.random.Generator
) -> np.ndarray:
    """Sunlight on points (n,), by one ray each to a random point of its disc."""
    sun = np.zeros(len(points), dtype=np.float32)
    if not around.sources.sun_rgb.any():
        return sun
    cosine = normals @ around.sources.to_sun
    ahead = np.flatnonzero(cosine > 0)
    spread = rng.standard_normal((len(ahead), 3), dtype=np.float32) * _SUN_SPREAD
    is_hidden = around.rays.is_hidden(points[ahead], around.sources.to_sun + spread)
    sun[ahead] = np.where(is_hidden, 0.0, cosine[ahead])
    return sun


def _scattered(
    around: _Surroundings, points: np.ndarray, normals: np.ndarray, rng: np.random.Generator
) -> np.ndarray:
    """Light on points (n, 3) from everything but the sun, with the grain of few rays."""
    n = len(points)
    rgb, sources = np.zeros((n, 3), dtype=np.float32), around.sources
    turn = rng.random(n, dtype=np.float32)
    u, v = _tangents(normals)
    for k in range(_N_SKY_RAYS):
        share = (k + rng.random(n, dtype=np.float32)) / _N_SKY_RAYS
        # Golden angle: the rays of a pixel spread evenly whatever its random turn.
        angle = 2 * np.pi * (turn + k * 0.618034)
        # Density proportional to the cosine (Malley's method), so that all rays count alike.
        x, y = np.sqrt(share) * np.cos(angle), np.sqrt(share) * np.sin(angle)
        height = np.sqrt(1.0 - share)
        rays = x[:, None] * u + y[:, None] * v + height[:, None] * normals
        hits = around.rays.first_hits(points, rays)
        up = np.clip(rays[:, 2:], 0.0, 1.0)
        sky = sources.level_rgb + up * (sources.zenith_rgb - sources.level_rgb)
        near = 1.0 - np.exp(-np.minimum(hits.distance, 50.0) / _BOUNCE_REACH_M)
        from_things = near[:, None] * sources.bounce_rgb
        from_things[around.is_lamp[hits.triangle]] = _LAMP_RGB
        is_free = (hits.triangle == NOTHING)[:, None]
        rgb += np.where(is_free, sky, from_things) / _N_SKY_RAYS
    return rgb


def _tangents(normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors orthogonal to each normal and to each other."""
    x, y, z = normals.T
    # Continuous except straight down (Duff et al. 2017, "Building an orthonormal basis").
    sign = np.where(z >= 0, np.float32(1), np.float32(-1))
    a = -1 / (sign + z)
    b = x * y * a
    u = np.stack([1 + sign * x * x * a, sign * b, -sign * x], axis=1)
    v = np.stack([b, sign + y * y * a, -y], axis=1)
    return u, v


def _exposed(light_rgb: np.ndarray) -> np.ndarray:
    """Brighten shadows and compress highlights."""
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
        """Return light without grain: averages with neighbours, over ever wider distances.

        Args:
            light: Light of each pixel, (h, w, c).
            steps: Distances in pixels to the neighbours, one for each average.
        """
        for step in steps:
            total = light.copy()
            weight = np.ones(light.shape[:2], dtype=np.float32)
            # Half of the eight directions: `_add` takes the opposite ones too.
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
