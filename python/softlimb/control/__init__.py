"""Control: pressures by PID against a pneumatic plant, and the posture by pressures."""

from softlimb.control.comparison import Comparison, candidates, compare
from softlimb.control.controllers import PID, NeuralPID
from softlimb.control.disturbances import DISTURBANCES, Disturbance, Event, follow
from softlimb.control.loop import Fault, Guard, PressureLoop, Trace
from softlimb.control.metrics import Metrics, metrics
from softlimb.control.pneumatics import Chamber, Gas, Line, Pneumatics, Sensor, Supply, Valve
from softlimb.control.posture_loop import Incident, PoseSensor, PostureControl, PostureRun, TipErrors, run_task
from softlimb.control.signals import SIGNALS, Signal, ramp, sine, staircase, steps
from softlimb.control.study import SeedRuns, posture_study
from softlimb.control.tasks import TASKS, Task, carry, circle, eight, still
from softlimb.control.true_limb import Perturbation, TrueLimb
from softlimb.control.tuning import LearningLimit, best_pid, best_rates, learning_from, learning_limit, simc, step_test

__all__ = [
    "DISTURBANCES",
    "PID",
    "SIGNALS",
    "TASKS",
    "Chamber",
    "Comparison",
    "Disturbance",
    "Event",
    "Fault",
    "Gas",
    "Guard",
    "Incident",
    "LearningLimit",
    "Line",
    "Metrics",
    "NeuralPID",
    "Perturbation",
    "Pneumatics",
    "PoseSensor",
    "PostureControl",
    "PostureRun",
    "PressureLoop",
    "SeedRuns",
    "Sensor",
    "Signal",
    "Supply",
    "Task",
    "TipErrors",
    "Trace",
    "TrueLimb",
    "Valve",
    "best_pid",
    "best_rates",
    "candidates",
    "carry",
    "circle",
    "compare",
    "eight",
    "follow",
    "learning_from",
    "learning_limit",
    "metrics",
    "posture_study",
    "ramp",
    "run_task",
    "simc",
    "sine",
    "staircase",
    "step_test",
    "steps",
    "still",
]
