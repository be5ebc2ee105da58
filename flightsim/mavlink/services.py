"""All microservices of a vehicle, and the service that answers each message."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from flightsim.mavlink.commands import CommandService, Executor
from flightsim.mavlink.dialect import LAYOUTS
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.failure_commands import FailureCommands
from flightsim.mavlink.faults import Faults
from flightsim.mavlink.files import FileService
from flightsim.mavlink.flight_commands import FlightCommands
from flightsim.mavlink.follow_target import FollowTargetService
from flightsim.mavlink.gps_input import GpsInputService
from flightsim.mavlink.guided import GuidedInput
from flightsim.mavlink.heartbeats import HeartbeatService
from flightsim.mavlink.landing_target import LandingTargetService
from flightsim.mavlink.lockstep import Lockstep
from flightsim.mavlink.logs import FlightRecorder, LogService
from flightsim.mavlink.maintenance_commands import MaintenanceCommands
from flightsim.mavlink.manual_control import ManualControlService
from flightsim.mavlink.message_commands import IdentityCommands, MessageCommands
from flightsim.mavlink.metadata import PACKED_PARAMETERS, MetadataService, PackedParameters
from flightsim.mavlink.mission import FENCE, MISSION, RALLY, MissionService
from flightsim.mavlink.mission_with_home import MissionWithHome
from flightsim.mavlink.mode_report import ModeReport
from flightsim.mavlink.motor_commands import MotorCommands
from flightsim.mavlink.obstacle_distance import ObstacleDistanceService
from flightsim.mavlink.offboard import OffboardService
from flightsim.mavlink.old_requests import OldRequestService
from flightsim.mavlink.parameter_names import AliasedParameters
from flightsim.mavlink.parameters import NamedParameters, ParameterService
from flightsim.mavlink.payload import PayloadComponents
from flightsim.mavlink.personalities import Personality
from flightsim.mavlink.service import (
    CommonService,
    Handler,
    Partners,
    Service,
    StatefulService,
    Watching,
)
from flightsim.mavlink.shell import ShellService
from flightsim.mavlink.signing import Signing
from flightsim.mavlink.signing_setup import SigningSetup
from flightsim.mavlink.statustext import StatustextSender
from flightsim.mavlink.streaming import KernelInputs
from flightsim.mavlink.telemetry import Producer, TelemetryService
from flightsim.mavlink.telemetry_motors import MotorTelemetry
from flightsim.mavlink.telemetry_sensors import SensorTelemetry
from flightsim.mavlink.telemetry_status import StatusTelemetry
from flightsim.mavlink.telemetry_surroundings import SurroundingsTelemetry
from flightsim.mavlink.timesync import TimesyncService
from flightsim.mavlink.view import VehicleView
from flightsim.mavlink.vision import VisionService

_FIX_HINT = "GPS_TYPE = 14 lets it be used"


@dataclass(frozen=True, kw_only=True)
class Setting:
    """Parts that the services are built from."""

    view: VehicleView
    """The vehicle, as reports and requests see it."""
    partners: Partners
    """Present partners."""
    statustext: StatustextSender
    """Texts for all partners."""
    personality: Personality
    """Flight stack to imitate."""
    system_id: int
    """MAVLink system id of the vehicle."""
    signing: Signing | None
    """Key and signatures of the links; None if they do not sign."""
    lockstep: Lockstep | None
    """Lets a client keep the time; None if none may."""
    faults: Faults
    """Guards work for clients."""
    payload: PayloadComponents | None
    """Camera and gimbal; None carries neither."""


class Services:
    """All microservices of one vehicle.

    Attributes:
        telemetry: Streams.
        missions: Missions, fences and rally points.
        watching: Observers of each tick, for nobody in particular.
        stateful: Services that act by themselves.
        common: Services that act for all partners together.
        handlers: Handler of each message, by its id.
    """

    def __init__(self, setting: Setting) -> None:
        """Build all services, and set the personality's choices in autopilot and plant."""
        view, personality, payload = setting.view, setting.personality, setting.payload
        # ArduPilot turns the fence on by an upload; PX4 has no switch, so its fence always counts.
        view.autopilot.fence.switch = None if personality.switches_fence else True
        view.plant.external_aids.fix_source = personality.fix_source
        unknown = () if personality.switches_fence else (mav.MAV_CMD_DO_FENCE_ENABLE,)
        view.autopilot.mission.unknown_commands = frozenset(unknown)
        modes = ModeReport(personality, view.autopilot)
        guided = GuidedInput(view, modes) if personality.has_guided_mode else None
        metadata = MetadataService(view, setting.partners) if personality.has_metadata else None
        recorder = FlightRecorder(view, setting.statustext)
        parameters = _named_parameters(setting)
        packed = PackedParameters(parameters)

        def files() -> Mapping[str, bytes | bytearray]:
            described = metadata.files if metadata else {}
            return {**recorder.files(), PACKED_PARAMETERS: packed.file(), **described}

        self.telemetry = _telemetry(setting, modes, metadata.producers if metadata else {})
        self.missions = _missions(setting, guided)
        fixes = GpsInputService(view, setting.statustext, _FIX_HINT)
        vision = VisionService(view, setting.statustext, personality.vision_switch)
        self.watching: Sequence[Watching] = (
            *(recorder, fixes, vision),
            *((metadata,) if metadata else ()),
        )
        self.stateful: Sequence[StatefulService] = (
            self.missions,
            _parameters(setting, parameters),
            ShellService(view, has_shell=personality.has_shell),
            LogService(recorder),
            FileService(files),
        )
        self.common: Sequence[CommonService] = (
            HeartbeatService(view.autopilot),
            self.telemetry,
            *((payload,) if payload else ()),
        )
        stateless = _answering(setting, modes, guided, self.telemetry)
        watched = (metadata,) if metadata else ()
        # A later service would replace an earlier one that answers the same message.
        answering = (*stateless, fixes, vision, *watched, *self.stateful, *self.common)
        self.handlers: dict[int, Handler] = {
            LAYOUTS[name].message_id: handler
            for service in answering
            for name, handler in service.handlers.items()
        }


def _answering(
    setting: Setting, modes: ModeReport, guided: GuidedInput | None, telemetry: TelemetryService
) -> Sequence[Service]:
    """Return the services that do nothing by themselves."""
    view, statustext, signing = setting.view, setting.statustext, setting.signing
    flight_commands = FlightCommands(view, setting.personality, modes)
    accept = guided.accept_setpoint if guided else view.autopilot.set_offboard_setpoint
    return (
        CommandService(_executors(setting, flight_commands, telemetry), statustext),
        OldRequestService(flight_commands, setting.personality, telemetry, statustext),
        OffboardService(view, accept),
        FollowTargetService(view),
        LandingTargetService(view),
        ObstacleDistanceService(view),
        ManualControlService(view, setting.system_id),
        TimesyncService(lambda: view.plant.time_us),
        *((SigningSetup(signing, view.autopilot, statustext),) if signing else ()),
    )


def _executors(
    setting: Setting, flight_commands: FlightCommands, telemetry: TelemetryService
) -> Mapping[int, Executor]:
    """Return the executor of each command; a later group replaces an earlier one."""
    view, statustext, personality = setting.view, setting.statustext, setting.personality
    messages = MessageCommands(telemetry)
    return {
        **flight_commands.executors,
        **(setting.payload.executors if setting.payload else {}),
        **messages.executors,
        **IdentityCommands(messages, personality, statustext).executors,
        **FailureCommands(view, statustext).executors,
        **MotorCommands(view, personality).executors,
        **MaintenanceCommands(view, statustext).executors,
        **(setting.lockstep.executors if setting.lockstep else {}),
    }


def _missions(setting: Setting, guided: GuidedInput | None) -> MissionService:
    autopilot, personality = setting.view.autopilot, setting.personality
    mission = MissionWithHome(autopilot) if personality.n_home_items else autopilot.mission
    return MissionService(
        {MISSION: mission, FENCE: autopilot.fence, RALLY: autopilot.rally},
        setting.partners,
        setting.statustext,
        guided.accept_item if guided else None,
        requests_int=personality.requests_int,
    )


def _named_parameters(setting: Setting) -> NamedParameters:
    """Return the autopilot's parameters, under the names of the flight stack."""
    view, personality = setting.view, setting.personality
    has_names = bool(personality.aliases)
    return AliasedParameters(view, personality) if has_names else view.autopilot.parameters


def _parameters(setting: Setting, parameters: NamedParameters) -> ParameterService:
    return ParameterService(
        parameters,
        setting.partners,
        setting.statustext,
        has_bytewise_integers=setting.personality.has_bytewise_integers,
    )


def _telemetry(
    setting: Setting, modes: ModeReport, more: Mapping[str, Producer]
) -> TelemetryService:
    view, personality = setting.view, setting.personality
    return TelemetryService(
        {
            **StatusTelemetry(view, personality, modes, setting.system_id).producers,
            **SensorTelemetry(view).producers,
            **MotorTelemetry(view).producers,
            **SurroundingsTelemetry(view).producers,
            **personality.extra_telemetry(view),
            **_of_the_mount(setting),
            **more,
        },
        setting.partners,
        lambda: view.plant.time_us,
        setting.faults,
        KernelInputs(view),
    )


def _of_the_mount(setting: Setting) -> Mapping[str, Producer]:
    """Return the message in which the flight stack's own clients read the gimbal's attitude."""
    name = setting.personality.mount_message
    return {} if setting.payload is None else {name: setting.payload.producers[name]}
