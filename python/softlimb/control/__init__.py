"""Control: pressures by PID against a pneumatic plant, and the posture by pressures."""

from softlimb.control.controllers import PID, NeuralPID
from softlimb.control.loop import Fault, Guard, PressureLoop, Trace
from softlimb.control.pneumatics import Chamber, Gas, Line, Pneumatics, Sensor, Supply, Valve

__all__ = [
    "PID",
    "Chamber",
    "Fault",
    "Gas",
    "Guard",
    "Line",
    "NeuralPID",
    "Pneumatics",
    "PressureLoop",
    "Sensor",
    "Supply",
    "Trace",
    "Valve",
]
