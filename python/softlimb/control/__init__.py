"""Control: pressures by PID against a pneumatic plant, and the posture by pressures."""

from softlimb.control.comparison import Comparison, candidates, compare
from softlimb.control.controllers import PID, NeuralPID
from softlimb.control.disturbances import DISTURBANCES, Disturbance, Event, follow
from softlimb.control.loop import Fault, Guard, PressureLoop, Trace
from softlimb.control.metrics import Metrics, metrics
from softlimb.control.pneumatics import Chamber, Gas, Line, Pneumatics, Sensor, Supply, Valve
from softlimb.control.signals import SIGNALS, Signal, ramp, sine, staircase, steps
from softlimb.control.tuning import LearningLimit, best_pid, best_rates, learning_from, learning_limit, simc, step_test

__all__ = [
    "DISTURBANCES",
    "PID",
    "SIGNALS",
    "Chamber",
    "Comparison",
    "Disturbance",
    "Event",
    "Fault",
    "Gas",
    "Guard",
    "LearningLimit",
    "Line",
    "Metrics",
    "NeuralPID",
    "Pneumatics",
    "PressureLoop",
    "Sensor",
    "Signal",
    "Supply",
    "Trace",
    "Valve",
    "best_pid",
    "best_rates",
    "candidates",
    "compare",
    "follow",
    "learning_from",
    "learning_limit",
    "metrics",
    "ramp",
    "simc",
    "sine",
    "staircase",
    "step_test",
    "steps",
]
