"""Design of limbs: parameters, criteria, and the search for the best by NLopt (``pip install 'softlimb[design]'``).

    problem = design.Problem(limb, [design.Number("segments[*].ring_radius", 20 * mm, 40 * mm)], design.Mass(), ...)
    best = design.optimise(problem, "slsqp");  best.values, best.limb, best.active
"""

from softlimb.design.criteria import (
    SIX_DIRECTIONS,
    BallooningMargin,
    Bending,
    Clearance,
    Compliance,
    Criterion,
    DesignFailure,
    LawMargin,
    Mass,
    Measure,
    Payload,
    PressureSet,
    Product,
    RingGap,
    StabilityMargin,
    TaskPressure,
    WeightedSum,
    WorkspaceBox,
    WorkspaceReach,
    WorkspaceVolume,
)
from softlimb.design.history import History
from softlimb.design.many import evaluate_many
from softlimb.design.numbers import LimbNumbers
from softlimb.design.optimise import ALGORITHMS, optimise
from softlimb.design.optimum import Active, Optimum
from softlimb.design.parameters import Factor, FibrePitch, Number, Parameter, RadiusRatio, Rule, TubeScale
from softlimb.design.problem import Constraint, Evaluation, Problem
from softlimb.design.radius_ratio import FLEXIBILITIES, RatioStudy, radius_ratio

__all__ = [
    "ALGORITHMS",
    "FLEXIBILITIES",
    "SIX_DIRECTIONS",
    "Active",
    "BallooningMargin",
    "Bending",
    "Clearance",
    "Compliance",
    "Constraint",
    "Criterion",
    "DesignFailure",
    "Evaluation",
    "Factor",
    "FibrePitch",
    "History",
    "LawMargin",
    "LimbNumbers",
    "Mass",
    "Measure",
    "Number",
    "Optimum",
    "Parameter",
    "Payload",
    "PressureSet",
    "Problem",
    "Product",
    "RadiusRatio",
    "RatioStudy",
    "RingGap",
    "Rule",
    "StabilityMargin",
    "TaskPressure",
    "TubeScale",
    "WeightedSum",
    "WorkspaceBox",
    "WorkspaceReach",
    "WorkspaceVolume",
    "evaluate_many",
    "optimise",
    "radius_ratio",
]
