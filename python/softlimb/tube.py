"""Fibre-reinforced tubes: pressure to stretch and back, stress through the wall, and the section of a rod."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from operator import index as as_index
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb import _core
from softlimb._core import Fibres, Layer, Section
from softlimb.arguments import finite_array, one_finite, one_of, one_real, positive_array, real_array, shown, truth

if TYPE_CHECKING:
    from softlimb.limb import Rod

__all__ = ["FibreState", "Fibres", "Layer", "SectionAtPressure", "Tube", "TubeState", "WallStress"]

Array = NDArray[np.float64]
Law = _core.NeoHookean | _core.Yeoh | _core.MooneyRivlin | _core.Ogden | _core.Gent
Model = Literal["thick", "paper_reduced"]
SectionModel = Literal["tangent", "nonlinear", "paper"]
Valve = Literal["open", "locked"]

SECTION_MODELS = ("tangent", "nonlinear", "paper")
VALVES = ("open", "locked")
ENDS = ("free", "bonded")

KEVLAR_MODULUS = 31.067e9  # [Pa], Zhang et al.


@dataclass(frozen=True, eq=False)
class WallStress:
    """Cauchy stress at places of the wall, inside to outside [Pa]; every field has the shape of the radii.

    ``radius`` is deformed and ``reference_radius`` undeformed [m]. ``shear`` is the hoop-axial component.
    """

    radius: Array
    reference_radius: Array
    radial: Array
    hoop: Array
    axial: Array
    shear: Array


class FibreState(NamedTuple):
    """A fibre family in a state.

    Stretch at the inside and outside of its layer (number ``layer``, 0 inside); ``tension``, its mean pull over the
    layer's reference area across the fibres, k (stretch - 1) [Pa]; ``taut_fraction``, the part of the layer's volume
    where it is taut (1 for two-way fibres).
    """

    layer: int
    angle: float
    stretch_inside: float
    stretch_outside: float
    tension: float
    taut_fraction: float


class SectionAtPressure(NamedTuple):
    """Rest length [m] and section of a tube at a pressure, with their derivatives to the pressure [1/Pa].

    ``d_section`` holds derivatives field by field (of a nonlinear axial law: its coefficients and its range).
    """

    rest_length: float
    section: Section
    d_rest_length: float
    d_section: Section


class TubeState:
    """Equilibrium of a tube at one pressure or at many.

    Numbers when the pressure was a number, arrays of its shape when it was an array. ``success`` is true where an
    equilibrium was found that is stable; ``message`` says the rest in words. ``state[i]`` is one state of many.
    """

    __slots__ = ("_scalar", "_shape", "_states", "_tube")

    def __init__(self, tube: Tube, states: _core.TubeStates, shape: tuple[int, ...], scalar: bool) -> None:
        self._tube, self._states, self._shape, self._scalar = tube, states, shape, scalar

    def __reduce__(self) -> tuple[Any, ...]:
        return (TubeState, (self._tube, self._states, self._shape, self._scalar))

    def _given(self, values: NDArray[Any]) -> Any:
        return values[0].item() if self._scalar else values.reshape(self._shape)

    @property
    def tube(self) -> Tube:
        """The tube."""
        return self._tube

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of every array here; () for one state."""
        return self._shape

    @property
    def stretch(self) -> Any:
        """Length over undeformed length (lambda_z)."""
        return self._given(self._states.stretch)

    @property
    def inner_radius(self) -> Any:
        """Deformed inner radius [m]."""
        return self._given(self._states.inner_radius)

    @property
    def outer_radius(self) -> Any:
        """Deformed outer radius [m]."""
        return self._given(self._tube._outer_radius(self._states))

    @property
    def twist_rate(self) -> Any:
        """Twist per reference length [rad/m]."""
        return self._given(self._states.twist_rate)

    @property
    def pressure(self) -> Any:
        """Gauge pressure [Pa]: as given, or the answer where volume or stretch were given."""
        return self._given(self._states.pressure)

    @property
    def axial_force(self) -> Any:
        """External axial force, positive in tension [N]."""
        return self._given(self._states.axial_force)

    @property
    def torque(self) -> Any:
        """External torque [N m]; with bonded ends the ends' reaction."""
        return self._given(self._states.torque)

    @property
    def volume(self) -> Any:
        """Volume inside the tube [m^3]."""
        radius = self._states.inner_radius
        return self._given(np.pi * radius**2 * self._states.stretch * self._tube.length)

    @property
    def smallest_eigenvalue(self) -> Any:
        """Smallest eigenvalue of S H S over the free unknowns [N].

        H is the Hessian of the energy per reference length in (stretch, stretch * inner_radius^2, twist rate),
        S = diag(1, R_i^2, 1/R_i). Positive: stable under given pressure, force and torque.
        """
        return self._given(self._states.smallest_eigenvalue)

    @property
    def limit_pressure(self) -> Any:
        """Pressure at which stability is lost under the same force and torque [Pa], where known; else 0."""
        return self._given(self._states.limit_pressure)

    @property
    def stable(self) -> Any:
        """Stable under given pressure."""
        return self._given(self._states.stable)

    @property
    def success(self) -> Any:
        """An equilibrium was found, and it is stable under what was prescribed (pressure, or volume)."""
        return self._given(self._states.success)

    @property
    def iterations(self) -> Any:
        """Newton iterations."""
        return self._given(self._states.iterations)

    @property
    def model(self) -> str:
        """``thick`` or ``paper_reduced``."""
        return self._states.model(0) if len(self._states) else "thick"

    def _texts(self, text: Any) -> Any:
        if self._scalar:
            return text(0)
        values = np.empty(len(self._states), dtype=object)
        for i in range(len(self._states)):
            values[i] = text(i)
        return values.reshape(self._shape)

    @property
    def status(self) -> Any:
        """Outcome of the solver by name (``converged``, ``limit_point``, ``no_progress``, ...)."""
        return self._texts(self._states.status)

    @property
    def message(self) -> Any:
        """Outcome in words, with every remark."""
        return self._texts(lambda i: self._tube._message(self._states, i))

    @property
    def warnings(self) -> Any:
        """Remarks on an answer that stands: a tuple of sentences, empty when there is nothing to say."""
        return self._texts(lambda i: tuple(self._tube._remarks(self._states, i)))

    def flag(self, name: str) -> Any:
        """Is a remark made? Names: ``law_out_of_range``, ``locking``, ``slack_fibres``, ``near_ballooning``,
        ``negative_pressure``, ``unstable``, ``near_law_limit``.

        Raises
        ------
        ValueError
            There is no such remark.
        """
        if not isinstance(name, str) or name not in FLAGS:
            raise ValueError(f"flag name must be one of {', '.join(FLAGS)}, got {shown(name)}")
        return self._given((self._states.flags & FLAGS[name]) != 0)

    def _only(self, what: str) -> None:
        if not self._scalar:
            raise ValueError(f"{what} belongs to one state, this holds shape {self._shape}: take state[i] first")
        if self.model != "thick":
            raise ValueError(f"{what} needs the thick-walled model, this state is of {self.model!r}")

    def stress(self, radius: ArrayLike | None = None, *, reference_radius: ArrayLike | None = None) -> WallStress:
        """Cauchy stress through the wall.

        Parameters
        ----------
        radius : array_like, optional
            Deformed radii within the wall, ``inner_radius`` to ``outer_radius`` [m].
        reference_radius : array_like, optional
            Undeformed radii instead [m]. At a face between layers the inner layer's values are given. Default: 25
            radii a layer, faces included on both sides.

        Returns
        -------
        WallStress

        Raises
        ------
        ValueError
            A radius outside the wall, both kinds given, or not a single thick-walled state.
        """
        self._only("stress")
        if radius is not None and reference_radius is not None:
            raise ValueError("give radius or reference_radius, not both")
        if radius is None and reference_radius is None:
            # A face belongs to the layer inside it; a hair further out begins the next.
            reference_radius = np.concatenate(
                [np.linspace(layer.inner * (1 + 1e-12 * (i > 0)), layer.outer, 25)
                 for i, layer in enumerate(self._tube.layers)]
            )
        if radius is None:
            radii = real_array("reference_radius", cast(ArrayLike, reference_radius))
        else:
            radii = real_array("radius", radius)
        values = self._tube._stress(self._states, radii.ravel(), radius is None)
        if radii.ndim == 0:
            return WallStress(*(cast(Array, row[0]) for row in values))
        return WallStress(*(row.reshape(radii.shape) for row in values))

    @property
    def fibres(self) -> tuple[FibreState, ...]:
        """Stretch and tension of every family, layer by layer in the order given."""
        self._only("fibres")
        return tuple(FibreState(*values) for values in self._tube._fibres(self._states))

    def __len__(self) -> int:
        if self._scalar:
            raise TypeError("a single state has no length")
        return self._shape[0]

    def __getitem__(self, index: int) -> TubeState:
        if len(self._shape) != 1:
            raise TypeError(f"states of shape {self._shape} cannot be indexed: ask with a flat array")
        try:
            index = as_index(index)
        except TypeError:
            raise TypeError(f"index of a state must be an integer, got {shown(index)}") from None
        count = self._shape[0]
        if not -count <= index < count:
            raise IndexError(f"state {index} of {count}")
        return TubeState(self._tube, self._states.one(index % count), (), True)

    def __iter__(self) -> Iterator[TubeState]:
        return (self[i] for i in range(len(self)))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, TubeState):
            return NotImplemented
        return self._shape == other._shape and self._tube == other._tube and self._states == other._states

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        if self._scalar:
            return (
                f"TubeState(pressure={self.pressure:.6g}, stretch={self.stretch:.6g}, "
                f"inner_radius={self.inner_radius:.6g}, twist_rate={self.twist_rate:.4g}, success={self.success}, "
                f"message={self.message!r})"
            )
        failed = int(np.sum(~np.asarray(self.success)))
        return f"TubeState(shape={self._shape}, {'all succeeded' if failed == 0 else f'{failed} did not succeed'})"


FLAGS = {
    "law_out_of_range": 1,
    "locking": 2,
    "slack_fibres": 4,
    "near_ballooning": 8,
    "negative_pressure": 16,
    "unstable": 32,
    "near_law_limit": 64,
}


def _layers(given: Any) -> list[Layer]:
    if isinstance(given, Layer):
        return [given]
    try:
        layers = list(given)
    except TypeError:
        raise ValueError(f"layers must be a sequence of Layer, got {shown(given)}") from None
    for i, layer in enumerate(layers):
        if not isinstance(layer, Layer):
            raise ValueError(f"layers[{i}] must be a Layer, got {shown(layer)}")
    return layers


class Tube(_core.Tube):
    """A fibre-reinforced tube: layers of silicone with families of fibres, closed at its ends.

    Parameters
    ----------
    length : float
        At zero pressure [m].
    layers : sequence of Layer
        From inside out, adjoining.
    tension_only : bool
        Fibres carry no compression. Default: they act both ways, as in the paper.
    ends : {"free", "bonded"}
        Bonded ends do not turn against each other: the twist is blocked.
    mass : float, optional
        [kg]. Default: volume of the layers times the density of their silicone (a thread counts as silicone).
    cap_length : float
        Part of the length at each end that a rigid cap keeps at rest [m]. An extending tube loses about 0.06 of its
        radius to both caps together, a contracting one about 0.8 (against an unclamped one, by finite elements).

    Raises
    ------
    ValueError
        A length or mass is not a positive number, layers do not adjoin, an option is unknown.

    Notes
    -----
    Thick-walled incompressible tube, MECHANICS "Actuator" (Zhang et al. eq. 1-3, completed). A tube never changes;
    an answer does not depend on what was asked before.
    """

    def __init__(
        self,
        length: float,
        layers: Sequence[Layer],
        tension_only: bool = False,
        ends: Literal["free", "bonded"] = "free",
        mass: float | None = None,
        cap_length: float = 0.0,
    ) -> None:
        one_of("ends", ends, ENDS)
        mass = None if mass is None else one_real("mass", mass)
        super().__init__(
            length=one_real("length", length),
            layers=_layers(layers),
            tension_only=truth("tension_only", tension_only),
            ends=ends,
            mass=mass,
            cap_length=one_real("cap_length", cap_length),
        )
        object.__setattr__(self, "_given_mass", mass)

    @classmethod
    def fibre_reinforced(
        cls,
        length: float,
        *,
        radii: Sequence[float],
        core: Law,
        skin: Law,
        thread_diameter: float,
        pitch: float,
        thread: Literal["smeared", "layer"] = "smeared",
        angle: float | None = None,
        modulus: float = KEVLAR_MODULUS,
        tension_only: bool = False,
        ends: Literal["free", "bonded"] = "free",
        mass: float | None = None,
        cap_length: float = 0.0,
    ) -> Tube:
        """The usual FRA: a core, thread wound around it in two families, a skin over it.

        Parameters
        ----------
        length : float
            At zero pressure [m].
        radii : sequence of 3 float
            Inside of the core, outside of the core (where the thread lies), outside of the skin [m].
        core, skin : law
            Silicones.
        thread_diameter, pitch : float
            Of the thread; axial distance between turns of one family [m].
        thread : {"smeared", "layer"}
            Spread over the whole skin (as the paper does) or over a layer as thick as the thread, at the inside of
            the skin.
        angle : float, optional
            Of the families, + and - [rad]. Default: ``atan(pitch / (2 pi R_m))``.
        modulus : float
            Of the thread [Pa]. Default: Kevlar, 31.067 GPa.
        tension_only, ends, mass, cap_length
            As for `Tube`.

        Returns
        -------
        Tube

        Raises
        ------
        ValueError
            Radii not ascending, a thread thicker than the skin or than its pitch, or as for `Tube`.

        Notes
        -----
        Fraction of one family: ``(pi d^2/4) 2 R_m / (cos(angle) (R_o^2 - R_m^2) pitch)``, with the outer radius of
        the threaded layer for R_o.
        """
        given = real_array("radii", radii)
        if given.shape != (3,):
            raise ValueError(f"radii must be three numbers (R_i, R_m, R_o), got {shown(radii)}")
        inner, middle, outer = given.tolist()
        for name, law in (("core", core), ("skin", skin)):
            if not isinstance(law, Law):
                raise ValueError(f"{name} must be a material law, got {shown(law)}")
        thread_diameter, pitch = one_real("thread_diameter", thread_diameter), one_real("pitch", pitch)
        angle, modulus = None if angle is None else one_real("angle", angle), one_real("modulus", modulus)
        if not 0.0 < inner < middle < outer:
            raise ValueError(f"radii must be positive and ascending, got {inner!r}, {middle!r}, {outer!r}")
        if not isinstance(thread, str) or thread not in ("smeared", "layer"):
            raise ValueError(f'thread must be "smeared" or "layer", got {shown(thread)}')
        if thread_diameter > outer - middle:
            thickness = f"{outer - middle:.6g}"
            raise ValueError(
                f"thread_diameter must be at most the thickness of the skin, {thickness}, got {thread_diameter!r}"
            )
        face = outer if thread == "smeared" else middle + thread_diameter
        wound = _core.thread_geometry(
            inner=middle, outer=face, thread_diameter=thread_diameter, pitch=pitch, angle=angle
        )
        fibres = Fibres.pair(angle=wound.angle, modulus=modulus, fraction=wound.fraction)
        layers = [Layer(inner, middle, core), Layer(middle, face, skin, fibres=fibres)]
        if face < outer:
            layers.append(Layer(face, outer, skin))
        return cls(length, layers, tension_only=tension_only, ends=ends, mass=mass, cap_length=cap_length)

    def inflate(
        self, pressure: ArrayLike, axial_force: ArrayLike = 0.0, torque: ArrayLike = 0.0, model: Model = "thick"
    ) -> TubeState:
        """Equilibrium under pressure, axial force and torque.

        Parameters
        ----------
        pressure : array_like
            Gauge pressure [Pa], in any order; each answer stands by itself.
        axial_force : array_like
            External force at the closed ends, positive in tension [N].
        torque : array_like
            External torque [N m]; zero with bonded ends.
        model : {"thick", "paper_reduced"}
            The thick-walled tube, or eq. 3 of the paper alone (lambda_theta = 1, r = R; no force, no torque), kept for
            comparison.

        Returns
        -------
        TubeState
            Of the common shape of the arguments. A pressure past ballooning gives ``success`` false and says where
            the tube balloons; it does not raise.

        Raises
        ------
        ValueError
            An argument is not made of finite real numbers, shapes do not fit, or a torque is given to bonded ends.
        """
        if not isinstance(model, str) or model not in ("thick", "paper_reduced"):
            raise ValueError(f'model must be "thick" or "paper_reduced", got {shown(model)}')
        p = finite_array("pressure", pressure)
        f, t = finite_array("axial_force", axial_force), finite_array("torque", torque)
        try:
            p, f, t = np.broadcast_arrays(p, f, t)
        except ValueError as error:
            shapes = f"{p.shape}, {f.shape}, {t.shape}"
            raise ValueError(
                f"pressure, axial_force and torque have shapes {shapes}, which do not fit together"
            ) from error
        if model == "paper_reduced" and (np.any(f != 0.0) or np.any(t != 0.0)):
            raise ValueError('model "paper_reduced" knows no axial force and no torque: both must be zero')
        states = self._inflate(p.ravel(), f.ravel(), t.ravel(), model == "paper_reduced")
        return TubeState(self, states, p.shape, p.ndim == 0)

    def inflate_volume(
        self,
        volume: ArrayLike | None = None,
        *,
        inner_radius: ArrayLike | None = None,
        axial_force: float = 0.0,
        torque: float = 0.0,
    ) -> TubeState:
        """Equilibrium with a given volume or inner radius; the pressure is the answer.

        Continues past a limit point, where the pressure falls as the volume grows: ``stable`` is then false (a
        pressure source could not hold it) while ``success`` is true (a volume source can).

        Parameters
        ----------
        volume : array_like, optional
            Volume inside the tube, ``pi r_i^2 stretch length`` [m^3].
        inner_radius : array_like, optional
            Deformed inner radius instead [m].
        axial_force, torque : float
            As for `inflate`.

        Returns
        -------
        TubeState

        Raises
        ------
        ValueError
            Neither or both given, a value not finite and positive.
        """
        if (volume is None) == (inner_radius is None):
            raise ValueError("give either volume or inner_radius")
        name, given = ("volume", volume) if inner_radius is None else ("inner_radius", inner_radius)
        values = positive_array(name, cast(ArrayLike, given))
        force, twist = one_finite("axial_force", axial_force), one_finite("torque", torque)
        states = self._at_volume(values.ravel(), inner_radius is not None, force, twist)
        return TubeState(self, states, values.shape, values.ndim == 0)

    def inflate_to(self, stretch: ArrayLike) -> TubeState:
        """Equilibrium with a given stretch under pressure alone; the pressure is the answer.

        Parameters
        ----------
        stretch : array_like
            Length over undeformed length.

        Returns
        -------
        TubeState
            Where extension turns into contraction a stretch may occur at several pressures: this is the lowest, and
            `other_pressures` has the rest. Where no pressure reaches the stretch: the nearest state, ``success`` false.

        Raises
        ------
        ValueError
            A stretch is not finite and positive.
        """
        values = positive_array("stretch", stretch)
        return TubeState(self, self._at_stretch(values.ravel()), values.shape, values.ndim == 0)

    def pressure_for(self, stretch: ArrayLike) -> Any:
        """Pressure that gives a stretch, without force and torque [Pa].

        Parameters
        ----------
        stretch : array_like
            Length over undeformed length.

        Returns
        -------
        float or ndarray
            The lowest such pressure (see `other_pressures`), NaN where there is none: `inflate_to` then tells the
            nearest stretch and why. Source: Zhang et al., last line of Algorithm 1, for the thick-walled tube.

        Raises
        ------
        ValueError
            A stretch is not finite and positive.
        """
        state = self.inflate_to(stretch)
        pressure = np.where(state.success, state.pressure, np.nan)
        return float(pressure) if pressure.ndim == 0 else pressure

    def other_pressures(self, stretch: float) -> list[float]:
        """Further pressures, ascending, that give the same stretch as `pressure_for` does; mostly none [Pa]."""
        values = positive_array("stretch", stretch)
        return self._other_pressures(one_real("stretch", values))

    def section(self, pressure: float, model: SectionModel = "tangent", valve: Valve = "open") -> Section:
        """Section of the rod that stands for the tube, per rest length.

        Parameters
        ----------
        pressure : float
            [Pa]
        model : {"tangent", "nonlinear", "paper"}
            Tangent stiffness at the pressure; the same with the tube's own curve of axial force against stretch; or the
            paper's constants (E = 6 c1, area and second moment of the undeformed tube, silicone alone).
        valve : {"open", "locked"}
            Constant pressure or constant volume.

        Returns
        -------
        Section

        Raises
        ------
        ValueError
            The pressure is not finite, an option is unknown, or there is no stable equilibrium at this pressure.
        """
        return self.section_at(pressure, model, valve).section

    def section_at(
        self, pressure: float, model: SectionModel = "tangent", valve: Valve = "open"
    ) -> SectionAtPressure:
        """Rest length and section at a pressure, with their exact derivatives to the pressure.

        Parameters, errors: as for `section`.

        Returns
        -------
        SectionAtPressure
        """
        value = one_finite("pressure", pressure)
        one_of("section model", model, SECTION_MODELS)
        one_of("valve", valve, VALVES)
        found = self._section(value, model, valve, True)
        if found["status"] != "converged":
            raise ValueError(f"no section at a pressure of {value:.6g} Pa: {self.inflate(value).message}")
        return SectionAtPressure(
            found["rest_length"], found["section"], found["d_rest_length"], found["d_section"]
        )

    def rest_length(self, pressure: float) -> float:
        """Length at a pressure without force and torque [m]; errors as for `section`."""
        return self.section_at(pressure).rest_length

    def rod(self, pressure: float, model: SectionModel = "tangent", valve: Valve = "open") -> Rod:
        """The rod that stands for the tube at a pressure, at its rest length; arguments as for `section`."""
        from softlimb.limb import Rod

        at = self.section_at(pressure, model, valve)
        return Rod(at.section, at.rest_length, radius=self.outer_radius)

    def __reduce__(self) -> tuple[Any, ...]:
        given = (self.length, self.layers, self.tension_only, self.ends, self._given_mass, self.cap_length)
        return (Tube, given)

    _given_mass: float | None

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a tube does not change: make a new one instead of setting {name!r}")

    def __repr__(self) -> str:
        text = f"Tube(length={self.length:.6g}, layers={self.layers!r}"
        if self.tension_only:
            text += ", tension_only=True"
        if self.ends != "free":
            text += f", ends={self.ends!r}"
        if self._given_mass is not None:
            text += f", mass={self._given_mass:.6g}"
        if self.cap_length:
            text += f", cap_length={self.cap_length:.6g}"
        return text + ")"
