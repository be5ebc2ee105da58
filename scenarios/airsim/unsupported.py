"""Methods of AirSim's clients that this door does not offer, and why."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

_MOTORS = "the autopilot commands its motors itself; use a move, or angular rates and throttle"
_GAINS = "the controllers are tuned to the airframe; see docs/airframes.md"
_LOOKS = "what a scene looks like is part of the scene"
_STATIC = "objects stand where the scene has them"
_FILMING = "a run is recorded by --record from its beginning"
_FILM_CAMERA = "cameras are pinhole cameras; use simSetCameraFov"
_NO_SENSOR = "there is no such sensor"
_ANNOTATION = "annotation layers are Unreal's; use Segmentation"
_LIGHTS = "lights are part of the scene"
_DETECTION = "use Segmentation and simListSceneObjects"
_UNREAL = "there is no Unreal Engine"
_CAR = "vehicles are multirotors"

_BY_REASON: Mapping[str, tuple[str, ...]] = {
    _MOTORS: ("moveByMotorPWMs",),
    _GAINS: (
        "setAngleLevelControllerGains",
        "setAngleRateControllerGains",
        "setVelocityControllerGains",
        "setPositionControllerGains",
    ),
    _LOOKS: (
        "simSwapTextures",
        "simSetObjectMaterial",
        "simSetObjectMaterialFromTexture",
        "simSetTimeOfDay",
    ),
    _STATIC: ("simSetObjectPose", "simSetObjectScale", "simSpawnObject", "simDestroyObject"),
    _FILMING: ("startRecording", "stopRecording", "isRecording"),
    _FILM_CAMERA: (
        "simGetPresetLensSettings",
        "simGetLensSettings",
        "simSetPresetLensSettings",
        "simGetPresetFilmbackSettings",
        "simSetPresetFilmbackSettings",
        "simGetFilmbackSettings",
        "simSetFilmbackSettings",
        "simGetFocalLength",
        "simSetFocalLength",
        "simEnableManualFocus",
        "simGetFocusDistance",
        "simSetFocusDistance",
        "simGetFocusAperture",
        "simSetFocusAperture",
        "simEnableFocusPlane",
        "simGetDistortionParams",
        "simSetDistortionParam",
    ),
    _NO_SENSOR: (
        "getGPULidarData",
        "simSetGPULidarPose",
        "getEchoData",
        "simSetEchoPose",
        "getUWBData",
        "getUWBSensorData",
        "getWifiData",
        "getWifiSensorData",
    ),
    _ANNOTATION: (
        "simListAnnotationObjects",
        "simListAnnotationPoses",
        "simSetAnnotationObjectID",
        "simGetAnnotationObjectID",
        "simSetAnnotationObjectColor",
        "simGetAnnotationObjectColor",
        "simSetAnnotationObjectValue",
        "simGetAnnotationObjectValue",
        "simSetAnnotationObjectTextureByPath",
        "simEnableAnnotationObjectTextureByPath",
        "simGetAnnotationObjectTexturePath",
    ),
    _LIGHTS: (
        "simSetWorldLightVisibility",
        "simSetWorldLightIntensity",
        "simSetVehicleLightVisibility",
        "simSetVehicleLightIntensity",
    ),
    _DETECTION: (
        "simAddDetectionFilterMeshName",
        "simSetDetectionFilterRadius",
        "simClearDetectionMeshNames",
        "simGetDetections",
    ),
    _UNREAL: (
        "simRunConsoleCommand",
        "simLoadLevel",
        "simListAssets",
        "simListSceneObjectsTags",
        "simGetMeshPositionVertexBuffers",
    ),
    _CAR: ("setCarControls", "getCarState", "getCarControls", "getComputerVisionState"),
    "voxels of a scene come from aeroscene export": ("simCreateVoxelGrid",),
    "the plant takes no force from outside": ("simSetExtForce",),
    "the sensors stay where the airframe has them": (
        "simSetDistanceSensorPose",
        "simSetLidarPose",
    ),
    "the physics moves the vehicle; use simSetVehiclePose": (
        "simSetKinematics",
        "simSetPhysicsRawKinematics",
    ),
    "AirSim's safety checks are not the autopilot's; use its geofence by MAVLink": ("setSafety",),
}
NOT_OFFERED: Mapping[str, str] = MappingProxyType(
    {name: reason for reason, names in _BY_REASON.items() for name in names}
)
"""Reason by the name of the method."""
