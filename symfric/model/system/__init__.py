"""What a scene consists of: the mechanical system, its dry contacts, its sampled inputs."""

from symfric.model.system.contact import Contact
from symfric.model.system.signal import Signal
from symfric.model.system.system import System

__all__ = ["Contact", "Signal", "System"]
