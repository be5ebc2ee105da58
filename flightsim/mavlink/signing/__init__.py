"""Signatures of MAVLink 2 messages: the vehicle's key, and who may set it."""

from flightsim.mavlink.signing.key import KEY_BYTES, SigningKeyError, key_of_passphrase, read_key
from flightsim.mavlink.signing.signing import Signing

__all__ = ["KEY_BYTES", "Signing", "SigningKeyError", "key_of_passphrase", "read_key"]
