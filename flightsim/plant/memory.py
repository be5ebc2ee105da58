"""Memory of the plant: its record, and the arrays without a fixed size.

A compiled kernel can follow addresses but owns no memory. This module allocates everything for one
vehicle, writes the addresses into the record and keeps the arrays alive. It also draws all random
numbers, so that the kernel itself is a pure function of the record.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate
from typing import Any

import mujoco
import numpy as np

from autonomy.control import new_controller
from autonomy.control.cfg import controller_cfg_for
from autonomy.estimation import new_filter
from autonomy.model.quadrotor import GRAVITY_MPS2
from flightsim.draws import generator, seed_sequence
from flightsim.environment.dryden import stationary_states
from flightsim.environment.magnetic_field import FIELD_ENU_UT
from flightsim.environment.motion import new_movers, new_traffic, place_mover
from flightsim.environment.shelter import cached_shelter
from flightsim.environment.wind import AIR_NORMALS, CALM, WindCfg, new_air, set_wind
from flightsim.looks.movers import MOVER_CONTACT_BIT
from flightsim.plant.cfg import PlantCfg, estimator_cfg_for
from flightsim.plant.free_flight import new_free_flight
from flightsim.plant.mujoco_calls import functions, time_address
from flightsim.plant.rays import new_rays
from flightsim.plant.record import HISTORY_DTYPE, PLANT_DTYPE
from flightsim.plant.sensing import SENSORS
from flightsim.plant.sky import new_sky
from flightsim.plant.surfaces import new_surfaces
from flightsim.plant.surroundings import Surroundings
from flightsim.sensors.gnss import GRADES
from flightsim.sensors.sensor import NormalStream, SensorStart
from flightsim.sensors.vibration import new_vibration
from flightsim.vehicles.battery import amperes_per_cubed_speed
from flightsim.vehicles.rotor_model import drag_model, new_rotors
from flightsim.world import World

# Numbers of the streams besides those in `SENSORS`; a number in use never changes.
_AIR_STREAM, _FIRST_AIR_STREAM, _START_STREAM, _VIBRATION_STREAM = 9, 10, 11, 13
_SKY_STREAM = 14


class PlantMemory:
    """Everything that the kernel reads and writes for one vehicle.

    Attributes:
        world: The world as the vehicle has it.
        data: State of the physics.
        row: `PLANT_DTYPE` (n,), the records of all vehicles of the world.
        plants: `PLANT_DTYPE` (1,), the record of this vehicle.
        plant: The same record as a scalar view.
        qpos: True pose of the vehicle (7,) in MuJoCo's memory.
        qvel: True velocity of the vehicle (6,): linear in the world, angular in the body.
        history: `HISTORY_DTYPE`, one row per control tick of an advance.
        setpoint_flat: The setpoint as doubles.
        movers: `MOVER_DTYPE`, a row for each moving obstacle.
        traffic: `TRAFFIC_DTYPE`, the clock of the movers, as a view.
    """

    def __init__(
        self,
        world: World,
        cfg: PlantCfg,
        data: mujoco.MjData,
        row: np.ndarray,
        history: np.ndarray,
        surroundings: Surroundings,
        lead: PlantMemory | None,
    ) -> None:
        """Fill the record of a vehicle as it stands in `data`.

        Args:
            world: The world as the vehicle has it.
            cfg: Configuration of the plant.
            data: State of the physics.
            row: Records of all vehicles of the world.
            history: Log of this vehicle.
            surroundings: Surroundings for the same scene and effects.
            lead: Memory of the first vehicle in the same world, whose movers all vehicles share;
                None for the first.
        """
        self.world, self.data, self.row = world, data, row
        self.plants = row[world.number : world.number + 1]
        self.plant: np.void = self.plants[0]
        self._written = _written(self.plants, cfg)
        self.setpoint_flat = self.plants["setpoint"].view("f8")
        self.history = history
        # The first vehicle draws the numbers that it would draw alone in the world.
        self._stream = ("plant",) if world.number == 0 else ("plant", "vehicle", world.number)
        if lead is None:
            self.movers, self._mover_points = new_movers(world.obstacles)
            self.traffic: np.void = self.plant["traffic"]
        else:
            self.movers, self._mover_points = lead.movers, lead._mover_points
            self.traffic = lead.traffic
        self._around, self._cfg = surroundings, cfg
        self._shelter = np.zeros((*self._around.grid.shape, 3))
        self._name_movers(world)
        self._connect(world, cfg, data)
        self._build_vehicle(world, cfg)
        self._lay_out_normals(cfg)
        self._point_to_arrays()
        self.set_wind(CALM)
        self._keep()
        self._draw_start(cfg.seed)

    def restart(self, seed: int) -> None:
        """Fill the record anew for a vehicle as it stands in `data` now, in calm air.

        The result equals a new memory of this seed. It skips the work that does not depend on the
        seed.
        """
        self._restore()
        self._draw_start(seed)

    def load(self, world: World) -> None:
        """Read masses that have changed in the model; they count from the next start on.

        Args:
            world: The world with its model, which may be another one of the same sizes.
        """
        self.world = world
        self._restore()
        self._connect(world, self._cfg, self.data)
        self._keep()

    def draw_normals(self) -> None:
        """Draw the noise of the next second."""
        for stream in self._streams:
            stream.draw()
        if self._air_stream is not None and self.plant["air"]["turbulence_mps"] > 0.0:
            self._air_stream.draw()

    def set_wind(self, cfg: WindCfg) -> None:
        """Change the wind from the next advance on.

        Args:
            cfg: New wind; behind solids it is weaker, by fields that are solved once for each
                direction.
        """
        was_smooth = self.plant["air"]["turbulence_mps"] == 0.0
        around = self._around
        is_sheltered = around.is_sheltered and cfg.speed_mps + cfg.gust_mps > 0.0
        if is_sheltered:
            self._shelter[:] = cached_shelter(
                around.grid, around.blocks, around.ground_below_m, cfg.axis_enu
            )
        has_rooms = len(around.rooms) > 0
        set_wind(self.plant["air"], cfg, has_rooms=has_rooms, is_sheltered=is_sheltered)
        self.plant["rotors"]["wind_enu_mps"] = cfg.steady_enu_mps
        if was_smooth and cfg.turbulence_mps > 0.0:
            self._stir()

    def _stir(self) -> None:
        """Draw the turbulence of the next second, and at the first call also its present state."""
        if self._air_stream is None:
            states = stationary_states(self._generator(*self._stream, _FIRST_AIR_STREAM))
            self.plant["air"]["states"] = states
            self._air_stream = self._normal_stream(_AIR_STREAM, self._air_normals)
        self._air_stream.draw()

    def _generator(self, *stream: str | int) -> np.random.Generator:
        return generator(self._seed, self.world.scene.scene_id, *stream)

    def _normal_stream(self, number: int, block: np.ndarray) -> NormalStream:
        scene_id = self.world.scene.scene_id
        return NormalStream(seed_sequence(self._seed, scene_id, *self._stream, number), block)

    def _keep(self) -> None:
        """Copy the records as they are before anything is drawn, for `restart`."""
        self._kept = [part.copy() for part in self._written], self.movers.copy()

    def _restore(self) -> None:
        parts, movers = self._kept
        for written, kept in zip(self._written, parts, strict=True):
            written[:] = kept
        self.movers[:] = movers

    def _name_movers(self, world: World) -> None:
        """Write the body and the geom of each mover in the model into its record."""
        for index, mover in enumerate(self.movers):
            mover["body"] = world.mover_body_id(index)
            mover["geom"] = world.model.body_geomadr[mover["body"]]
            mover["contact_bits"] = MOVER_CONTACT_BIT
            place_mover(mover, self._mover_points, 0.0, 1.0)

    def _connect(self, world: World, cfg: PlantCfg, data: mujoco.MjData) -> None:
        """Set the clock, and the addresses of arrays in MuJoCo's memory."""
        e, model, body = self.plant["engine"], world.model, world.vehicle_body_id
        e["tick_us"] = self.tick_us = 1_000_000 // cfg.control_hz
        e["tick_hz"] = cfg.control_hz
        e["steps_per_tick"] = cfg.physics_hz // cfg.control_hz
        e["ticks_per_advance"] = cfg.control_hz // cfg.advance_hz
        e["has_power"], e["has_sensors"] = 1, cfg.has_sensors
        e["knows_truth"] = cfg.state == "truth"
        e["step_address"], e["clock_address"] = functions().step, functions().clock
        e["kinematics_address"] = functions().kinematics
        e["rays"] = new_rays(world, data)[0]
        self.plant["free_flight"] = new_free_flight(world, data, is_on=cfg.free_flight)[0]
        e["model_address"], e["data_address"] = model._address, data._address
        e["time_address"] = time_address(data)
        joint = model.body_jntadr[body]
        self.qpos = data.qpos[model.jnt_qposadr[joint] :][:7]
        dof = model.jnt_dofadr[joint]
        self.qvel = data.qvel[dof:][:6]
        for name, array in (
            ("qpos", self.qpos),
            ("qvel", self.qvel),
            ("applied", data.xfrc_applied[body]),
            ("constraint", data.qfrc_constraint[dof:]),
            ("mocap_pos", data.mocap_pos),
            ("mocap_quat", data.mocap_quat),
            ("geom_bits", model.geom_conaffinity),
            ("body_bits", model.body_conaffinity),
        ):
            e[f"{name}_address"] = array.ctypes.data
        e["n_geoms"], e["n_bodies"] = model.ngeom, model.nbody
        e["vehicle_body"] = body

    def _build_vehicle(self, world: World, cfg: PlantCfg) -> None:
        """Fill the records of the air, the rotors, the controller and the filter."""
        quadrotor, dt_s = world.airframe.quadrotor, 1.0 / cfg.control_hz
        self.plant["air"] = new_air(dt_s)[0]
        self.plant["air"]["shelter_cell_m"] = self._around.grid.cell_m
        self.plant["air"]["shelter_origin_enu_m"] = self._around.grid.origin_enu_m
        self.plant["traffic"] = new_traffic(dt_s)[0]
        self.plant["rotors"] = new_rotors(
            world.airframe,
            dt_s=1.0 / cfg.physics_hz,
            axial_limit_mps=cfg.rotor_axial_limit_mps,
            effects=cfg.effects,
        )[0]
        self.plant["surfaces"] = new_surfaces(cfg.effects)[0]
        gains = cfg.controller or controller_cfg_for(quadrotor)
        self.plant["controller"] = new_controller(quadrotor, gains, dt_s=dt_s)[0]
        self.plant["filter"] = new_filter(
            cfg.estimator or estimator_cfg_for(cfg),
            dt_s=dt_s,
            field_enu_ut=FIELD_ENU_UT,
            gravity_mps2=GRAVITY_MPS2,
            drag=drag_model(world.airframe, cfg.effects),
        )[0]

    def _lay_out_normals(self, cfg: PlantCfg) -> None:
        """Allocate the noise of a second: a block for each sensor, then one for the air."""
        sensors = SENSORS if cfg.has_sensors else ()
        sizes = [
            # A sensor without a rate of its own measures at every control tick.
            getattr(sensor.cfg(cfg), "rate_hz", cfg.control_hz) * sensor.n_normals
            for sensor in sensors
        ]
        ends = list(accumulate(sizes, initial=0))
        self._normals = np.zeros(ends[-1] + cfg.control_hz * AIR_NORMALS)
        *blocks, self._air_normals = np.split(self._normals, ends[1:])
        self._sensors = list(zip(sensors, ends, blocks, strict=False))
        self.plant["air"]["first_normal"] = ends[-1]

    def _draw_start(self, seed: int) -> None:
        """Draw what differs between flights: the sky, each sensor's errors and noise, the start.

        Without sensors nothing reads these numbers, so they are not drawn. The air draws its own
        when the wind becomes turbulent.
        """
        self._seed = seed
        self._air_stream: NormalStream | None = None
        self._streams: list[NormalStream] = []
        if self._cfg.has_sensors:
            self._switch_on(self.world, self._cfg)

    def _switch_on(self, world: World, cfg: PlantCfg) -> None:
        """Fill the records of the sky and the sensors, and give each sensor its stream of noise."""
        self.plant["sky"] = new_sky(
            GRADES[cfg.gnss].constellations,
            world.scene.latitude_deg,
            # One sky stands over all vehicles of a world.
            self._generator("plant", _SKY_STREAM),
            cfg.effects,
        )[0]
        self.plant["vibration"] = new_vibration(
            world.airframe,
            self._generator(*self._stream, _VIBRATION_STREAM),
            dt_s=1.0 / cfg.control_hz,
            is_on=cfg.effects.vibration,
        )[0]
        if cfg.aiding != "gnss":
            # With other aiding than satellites alone the filter is given its start, with an error.
            sigma_m = (cfg.estimator or estimator_cfg_for(cfg)).start_sigma_m
            believed = self._generator(*self._stream, _START_STREAM)
            f: np.void = self.plant["filter"]
            f["has_start"], f["start_enu_m"] = 1, believed.normal(self.qpos[:3], sigma_m)
        amperes = amperes_per_cubed_speed(world.airframe.battery)
        for sensor, first, block in self._sensors:
            start = SensorStart(
                tick_hz=cfg.control_hz,
                rng=self._generator(*self._stream, *sensor.start_streams),
                position_enu_m=self.qpos[:3],
                velocity_enu_mps=self.qvel[:3],
                quat_wxyz=self.qpos[3:7],
                altitude_m=world.scene.altitude_m,
                amperes_per_cubed_speed=amperes if cfg.effects.motor_field else 0.0,
            )
            self.plant[sensor.name] = sensor.new(sensor.cfg(cfg), start)[0]
            record = self.plant[sensor.name]
            record["first_normal"], record["is_enabled"] = first, cfg.has(sensor.name)
            self._streams.append(self._normal_stream(sensor.stream, block))

    def _point_to_arrays(self) -> None:
        """Write the addresses and lengths of the arrays without a fixed size into the record."""
        e = self.plant["engine"]
        for name, array in (
            ("movers", self.movers),
            ("mover_points", self._mover_points),
            ("rooms", self._around.rooms),
            ("steel", self._around.steel),
            ("normals", self._normals),
        ):
            e[f"{name}_address"], e[f"n_{name}"] = array.ctypes.data, len(array)
        e["shelter_address"], e["shelter_shape"] = (
            self._shelter.ctypes.data,
            self._around.grid.shape,
        )
        e["history_address"] = self.history.ctypes.data


def _written(plants: np.ndarray, cfg: PlantCfg) -> list[np.ndarray]:
    """Return the bytes of a record that a flight changes, as views.

    Without sensors, the records of the sensors and of the filter never change and need no copies.
    """
    record = plants.view(np.uint8)
    if cfg.has_sensors:
        return [record]
    places: Any = PLANT_DTYPE.fields
    first, last = places[SENSORS[0].name][1], places["state"][1]
    return [record[:first], record[last:]]


def new_memories(
    views: Sequence[World],
    cfg: PlantCfg,
    data: mujoco.MjData,
    *,
    row: np.ndarray | None = None,
    histories: np.ndarray | None = None,
    surroundings: Surroundings | None = None,
) -> list[PlantMemory]:
    """Return the memory of each vehicle of a world, as it stands in `data`.

    Args:
        views: The world as each of its vehicles has it.
        cfg: Configuration of all vehicles.
        data: State of the physics.
        row: Records of the vehicles if they are part of a larger array; new ones by default.
        histories: Logs of the vehicles, a row for each, if they are part of a larger array.
        surroundings: Surroundings of the same scene and effects, if they are known already.
    """
    row = np.zeros(len(views), PLANT_DTYPE) if row is None else row
    if histories is None:
        histories = np.zeros((len(views), cfg.control_hz // cfg.advance_hz), HISTORY_DTYPE)
    around = surroundings or Surroundings.from_scene(views[0].scene, cfg.effects)
    memories: list[PlantMemory] = []
    for view, history in zip(views, histories, strict=True):
        lead = memories[0] if memories else None
        memories.append(PlantMemory(view, cfg, data, row, history, around, lead))
    return memories
