"""Moving obstacles from onboard depth: blobs that the map does not explain, tracked over images.

Each image's foreground falls into blobs, and blobs close together are one sighting. A sighting goes
to the track that expected it, the best pairs first. An unexpected sighting begins a track, which
counts once a few images have shown it, because noise rarely repeats itself. A track ends when
images show the background of its expected place, or when it was not seen for a while.

An obstacle at rest that is not on the map, for example a person who waits, is followed like the
rest, because it is as much in the way.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from autonomy.perception.cell_distances import CellDistances, StaticDistance
from autonomy.perception.depth_image import DepthImage
from autonomy.perception.foreground import find_blobs, find_foreground
from autonomy.perception.mover_track import MoverTrack
from autonomy.perception.sighting import Sighting, see
from autonomy.planning.moving_obstacles import MovingObstacles

# Cells of cached distances; gap within which blobs, and their pixels, belong together.
_CELL_M = 0.2
_BLOB_GAP_M = 0.35
_MOST_SIGHTINGS = 24  # of one image, the largest: the time of a frame stays bounded
_ROUNDING_M = 0.3  # greatest radius by which a mover's box is rounded
_COAST_NEW_S = 1.0  # an unconfirmed track is dropped sooner


@dataclass(frozen=True, kw_only=True, slots=True)
class MoverTrackerCfg:
    """Settings for finding and following moving obstacles."""

    static_within_m: float = 0.35
    """Distance to the map within which a point counts as part of it."""
    mover_beyond_m: float = 0.55
    """Distance from the map beyond which some points of a mover must lie. It must cover the error
    of the estimated pose and the 17 cm by which cached distances err. A mover nearer than this to a
    wall is not seen."""
    range_m: float = 16.0
    """Depth beyond which pixels are ignored."""
    most_depth_sigma_m: float = 0.3
    """Standard deviation of depth above which pixels are ignored."""
    least_samples: int = 5
    """Number of samples beyond that distance that make a mover. One sample stands for two by two
    pixels, in a wide view for one."""
    most_size_m: float = 7.0
    """Size above which a blob is no mover but something large that the map lacks."""
    hits_to_confirm: int = 3
    """Number of images that must show an obstacle before it counts."""
    misses_to_end: int = 2
    """Number of images in a row that show what is behind an obstacle, after which it is gone."""
    coast_s: float = 5.0
    """Time for which an obstacle out of sight is predicted."""
    gate: float = 16.0
    """Largest squared Mahalanobis distance of a sighting from its track."""
    remember_s: float = math.inf
    """Time for which distances to the map are kept. With a growing map: 0 if its distances are
    cheap, else as short as the time between images."""
    margin_sigmas: float = 1.0
    """Number of standard deviations of position added to a radius, and of velocity to its growth.
    """
    most_margin_m: float = 0.5
    """Greatest addition to a radius."""
    most_growth_mps: float = 0.4
    """Greatest growth of radii. All grow as fast as the radius of the least certain obstacle."""
    horizon_s: float = 4.0
    """Time for which predictions are valid."""


class MoverTracker:
    """Tracks moving obstacles over depth images.

    Attributes:
        tracks: All tracks, confirmed or not yet.
    """

    def __init__(self, cfg: MoverTrackerCfg | None = None) -> None:
        self._cfg = MoverTrackerCfg() if cfg is None else cfg
        self._cells = CellDistances(_CELL_M, self._cfg.remember_s)
        self.tracks: list[MoverTrack] = []

    def update(self, time_s: float, image: DepthImage, static_distance_m: StaticDistance) -> None:
        """Update the tracks with one depth image.

        Args:
            time_s: Time of the image; not before the last one.
            image: Image posed by the estimate.
            static_distance_m: Distance from points, ENU (n, 3), to obstacles known to stand. With a
                growing map: to cells that were occupied for a second or more, and 0 or less where
                nothing was ever seen to be free, because an object that comes into view there need
                not move.
        """
        self._cells.forget_old(time_s)
        for track in self.tracks:
            track.predict(time_s)
        seen, unexpected = self._match(self._sightings(image, static_distance_m))
        for track in self.tracks:
            if track not in seen and track.is_seen_through(image):
                track.n_misses += 1
        self.tracks = [track for track in self.tracks if self._is_kept(track, time_s)]
        self.tracks += [MoverTrack(time_s, sighting) for sighting in unexpected]

    def in_question(self) -> Float[np.ndarray, "n 3"]:
        """Positions of tracks that are not confirmed yet and deserve another look, ENU."""
        cfg = self._cfg
        places = [track.mean[:3] for track in self.tracks if track.n_hits < cfg.hits_to_confirm]
        return np.array(places).reshape(-1, 3)

    def moving(self, time_s: float) -> MovingObstacles:
        """Confirmed obstacles, as predictions from a time on.

        Radii include the uncertainty of position, and the growth that of velocity, within the
        limits of the configuration.
        """
        cfg = self._cfg
        tracks = [track for track in self.tracks if track.n_hits >= cfg.hits_to_confirm]
        position, velocity, half = (np.zeros((len(tracks), 3)) for _ in range(3))
        radius, yaw, growth = np.zeros(len(tracks)), np.zeros(len(tracks)), 0.0
        for i, track in enumerate(tracks):
            mean, covariance = track.predicted(time_s)
            position[i], velocity[i] = mean[:3], mean[3:]
            variance = np.diagonal(covariance)
            size = np.array([track.size.along_m, track.size.across_m, track.size.up_m])
            rounding = min(float(size.min()), _ROUNDING_M)
            half[i], yaw[i] = size - rounding, track.size.yaw_rad
            unsure_m = cfg.margin_sigmas * math.sqrt(variance[:2].max())
            radius[i] = rounding + min(unsure_m, cfg.most_margin_m)
            growth = max(growth, cfg.margin_sigmas * math.sqrt(variance[3:5].max()))
        return MovingObstacles(
            position_enu_m=position,
            velocity_enu_mps=velocity,
            radius_m=radius,
            half_extent_m=half,
            yaw_rad=yaw,
            growth_mps=min(growth, cfg.most_growth_mps),
            horizon_s=cfg.horizon_s,
        )

    def _sightings(self, image: DepthImage, static_distance_m: StaticDistance) -> list[Sighting]:
        cfg = self._cfg
        within_m, range_m = cfg.static_within_m, cfg.range_m
        if image.inverse_depth_sigma_pm > 0.0:
            known_m = math.sqrt(cfg.most_depth_sigma_m / image.inverse_depth_sigma_pm)
            # Depth errs by inverse_sigma d^2; beyond this range that is more than allowed.
            range_m = min(range_m, known_m)
        foreground = find_foreground(
            image, self._cells, static_distance_m, within_m=within_m, range_m=range_m
        )
        blobs = find_blobs(
            foreground,
            image,
            gap_m=_BLOB_GAP_M,
            beyond_m=cfg.mover_beyond_m,
            least_samples=cfg.least_samples,
        )
        blobs = _joined(foreground.points_enu_m, blobs[:_MOST_SIGHTINGS])
        return [
            see(image, foreground, blob, within_m=within_m)
            for blob in blobs
            if np.ptp(foreground.points_enu_m[blob], axis=0).max() <= cfg.most_size_m
        ]

    def _match(self, sightings: list[Sighting]) -> tuple[list[MoverTrack], list[Sighting]]:
        """Assign sightings to tracks; return the tracks with one and the sightings left over."""
        pairs = sorted(
            (surprise, i, j)
            for i, track in enumerate(self.tracks)
            for j, sighting in enumerate(sightings)
            if (surprise := track.surprise(sighting)) < self._cfg.gate
        )
        tracks, taken = set[int](), set[int]()
        for _, i, j in pairs:
            if i not in tracks and j not in taken:
                self.tracks[i].see(sightings[j])
                tracks.add(i)
                taken.add(j)
        unexpected = [sighting for j, sighting in enumerate(sightings) if j not in taken]
        return [self.tracks[i] for i in tracks], unexpected

    def _is_kept(self, track: MoverTrack, time_s: float) -> bool:
        cfg = self._cfg
        is_new = track.n_hits < cfg.hits_to_confirm
        if track.n_misses >= cfg.misses_to_end:
            return False
        return time_s - track.last_seen_s <= (_COAST_NEW_S if is_new else cfg.coast_s)


def _joined(points: np.ndarray, blobs: list[np.ndarray]) -> list[np.ndarray]:
    """Merge blobs whose upright boxes are close together."""
    joined: list[np.ndarray] = []
    for blob in blobs:
        near = [other for other in joined if _gap_m(points[blob], points[other]) < _BLOB_GAP_M]
        joined = [other for other in joined if not any(other is one for one in near)]
        joined.append(np.concatenate([blob, *near]))
    return joined


def _gap_m(one: np.ndarray, other: np.ndarray) -> float:
    """Distance between the upright boxes about two sets of points, m."""
    apart = np.maximum(one.min(axis=0) - other.max(axis=0), other.min(axis=0) - one.max(axis=0))
    return float(np.linalg.norm(np.maximum(apart, 0.0)))
