"""
Compiled core of softlimb: sections, laws, tubes, rods, limbs. SI units throughout.
"""
from __future__ import annotations
import collections.abc
import numpy
import numpy.typing
import typing
__all__: list[str] = ['Atlas', 'CHUNK_ROWS', 'Derivatives', 'DruckerCheck', 'Fibres', 'FollowedPath', 'Gent', 'Geometry', 'Layer', 'Members', 'MooneyRivlin', 'NeoHookean', 'NeuralPid', 'Ogden', 'Parameters', 'Pid', 'PlainSolver', 'Plant', 'Posture', 'PressureLoop', 'Reached', 'Scene', 'Section', 'ThreadGeometry', 'Tube', 'TubeStates', 'Yeoh', 'axial_strain', 'axial_strain_slope', 'build_info', 'follow', 'instruction_set', 'instruction_sets', 'integrator_orders', 'law_class_names', 'law_coefficients', 'linearised', 'orifice_flow', 'plain_reach', 'potential_energy', 'potential_energy_slopes', 'reach', 'rest_length_slopes', 'rod_end', 'status_names', 'survey_rows', 'sweep_rows', 'thread_geometry', 'tip_by_pressures', 'use_instruction_set', 'yardstick']
class Section:
    """
    Stiffness of a rod's cross-section, per rest length, SI.
    
    Transversely isotropic about the rod's axis: ``n = R diag(GA, GA, EA) (v - v*)``, ``m = R diag(EI, EI, GJ) (u - u*)``
    with ``v* = (0, 0, 1)`` and ``u* = (0, 0, rest_twist)``. Source: MECHANICS, "Section".
    
    Parameters
    ----------
    axial, shear : float
        EA and GA [N].
    bending, torsion : float
        EI and GJ [N m^2].
    mass_per_length : float
        Mass per rest length [kg/m].
    rest_twist : float
        Twist of the unloaded section [rad/m].
    extension_twist : float
        Compliance that couples axial force to twist and axial moment to stretch [1/(N m)].
    
    Raises
    ------
    ValueError
        A value is not finite, a stiffness is not positive, a mass is negative, or the coupling is too strong.
    """
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> tuple[typing.Any, ...]:
        ...
    def __hash__(self) -> int:
        ...
    def __init__(self, *, axial: typing.SupportsFloat | typing.SupportsIndex, shear: typing.SupportsFloat | typing.SupportsIndex, bending: typing.SupportsFloat | typing.SupportsIndex, torsion: typing.SupportsFloat | typing.SupportsIndex, mass_per_length: typing.SupportsFloat | typing.SupportsIndex = 0.0, rest_twist: typing.SupportsFloat | typing.SupportsIndex = 0.0, extension_twist: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: tuple[typing.Any, ...]) -> None:
        ...
    @property
    def axial(self) -> float:
        """
        EA [N]
        """
    @property
    def bending(self) -> float:
        """
        EI [N m^2]
        """
    @property
    def extension_twist(self) -> float:
        """
        Coupling compliance [1/(N m)]
        """
    @property
    def largest_stretch(self) -> float:
        """
        Total stretch up to which the material laws were fitted; 0 when not known
        """
    @property
    def mass_per_length(self) -> float:
        """
        Mass per rest length [kg/m]
        """
    @property
    def nonlinear(self) -> bool:
        """
        True when the axial law is a curve and not the constant EA
        """
    @property
    def rest_twist(self) -> float:
        """
        Twist of the unloaded section [rad/m]
        """
    @property
    def shear(self) -> float:
        """
        GA [N]
        """
    @property
    def stretch(self) -> float:
        """
        Rest length over the length at zero pressure
        """
    @property
    def torsion(self) -> float:
        """
        GJ [N m^2]
        """
class DruckerCheck:
    """
    Outcome of `check_drucker` of a law; true when stable.
    """
    def __bool__(self) -> bool:
        ...
    def __getstate__(self) -> tuple[typing.Any, ...]:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: tuple[typing.Any, ...]) -> None:
        ...
    @property
    def margin(self) -> float:
        """
        Smallest d(stress) : d(strain) over the value of the undeformed material: 1 there, not positive where unstable, NaN where the law has no value.
        """
    @property
    def max_strain(self) -> float:
        """
        Largest nominal strain that was checked.
        """
    @property
    def message(self) -> str:
        """
        The outcome in words.
        """
    @property
    def stable(self) -> bool:
        """
        Stable over the whole range in all three tests.
        """
    @property
    def strain(self) -> float:
        """
        Nominal strain where stability is lost first; NaN if nowhere.
        """
    @property
    def test(self) -> str | None:
        """
        Test in which it is lost first: uniaxial, planar or equibiaxial; None if nowhere.
        """
class NeoHookean:
    """
    Neo-Hookean law: W = c1 (I1 - 3).
    
    Parameters
    ----------
    c1 : float
        Half the shear modulus [Pa], positive.
    density : float
        Density [kg/m^3].
    max_strain : float
        Largest nominal strain of the data behind the coefficients; 0 when not known. It judges results, it never
        changes them.
    
    Raises
    ------
    ValueError
        A value is not finite or breaks its rule, or the initial shear modulus 2 c1 is not positive.
    
    Notes
    -----
    Incompressible. Source: MECHANICS, "Material".
    """
    name: typing.ClassVar[str] = 'neo-hooke'
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> tuple[typing.Any, ...]:
        ...
    def __hash__(self) -> int:
        ...
    def __init__(self, *, c1: typing.SupportsFloat | typing.SupportsIndex, density: typing.SupportsFloat | typing.SupportsIndex = 1080.0, max_strain: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: tuple[typing.Any, ...]) -> None:
        ...
    def check_drucker(self, max_strain: typing.SupportsFloat | typing.SupportsIndex | None = None) -> DruckerCheck:
        """
        Is the law stable in Drucker's sense in tension, planar tension and equibiaxial tension?
        
        Stable means that any further strain at constant volume costs work, d(stress) : d(strain) > 0.
        
        Parameters
        ----------
        max_strain : float, optional
            Nominal strains 0..max_strain are checked. Default: the law's own `max_strain`.
        
        Returns
        -------
        DruckerCheck
            True in a condition when stable; says where stability is lost first otherwise.
        
        Raises
        ------
        ValueError
            `max_strain` is not positive, or not given and not known to the law.
        """
    def energy_derivatives(self, a: typing.SupportsFloat | typing.SupportsIndex, t: typing.SupportsFloat | typing.SupportsIndex) -> tuple[float, float, float, float, float, float]:
        """
        Energy density and its derivatives (w, w_a, w_t, w_aa, w_at, w_tt) [Pa].
        
        Parameters
        ----------
        a : float
            Squared stretch in one principal direction.
        t : float
            Sum of the squared stretches in the other two, at least 2/sqrt(a).
        
        Raises
        ------
        ValueError
            `a` is not positive, or `t` too small to be a sum of real squares with product 1/a.
        """
    def energy_third_derivatives(self, a: typing.SupportsFloat | typing.SupportsIndex, t: typing.SupportsFloat | typing.SupportsIndex) -> tuple[float, float, float, float]:
        """
        Third derivatives (w_aaa, w_aat, w_att, w_ttt) [Pa]; arguments as in `energy_derivatives`.
        """
    @typing.overload
    def equibiaxial_stress(self, stretch: float) -> float:
        """
        Nominal stress in equibiaxial tension, in each of the two directions.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def equibiaxial_stress(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Nominal stress in equibiaxial tension, in each of the two directions.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def equibiaxial_tangent(self, stretch: float) -> float:
        """
        Derivative of the nominal stress in the stretch, in equibiaxial tension, in each of the two directions.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def equibiaxial_tangent(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Derivative of the nominal stress in the stretch, in equibiaxial tension, in each of the two directions.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def planar_stress(self, stretch: float) -> float:
        """
        Nominal stress in planar tension (pure shear: one lateral direction held).
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def planar_stress(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Nominal stress in planar tension (pure shear: one lateral direction held).
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def planar_tangent(self, stretch: float) -> float:
        """
        Derivative of the nominal stress in the stretch, in planar tension (pure shear: one lateral direction held).
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def planar_tangent(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Derivative of the nominal stress in the stretch, in planar tension (pure shear: one lateral direction held).
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def uniaxial_stress(self, stretch: float) -> float:
        """
        Nominal stress in uniaxial tension or compression.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def uniaxial_stress(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Nominal stress in uniaxial tension or compression.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def uniaxial_tangent(self, stretch: float) -> float:
        """
        Derivative of the nominal stress in the stretch, in uniaxial tension or compression.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def uniaxial_tangent(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Derivative of the nominal stress in the stretch, in uniaxial tension or compression.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @property
    def c1(self) -> float:
        """
        Half the shear modulus [Pa], positive.
        """
    @property
    def density(self) -> float:
        """
        Density [kg/m^3].
        """
    @property
    def max_strain(self) -> float:
        """
        Largest nominal strain of the fit range; 0 when not known.
        """
    @property
    def parameters(self) -> dict[str, typing.Any]:
        """
        Coefficients by name (a new dict); lists of coefficients are tuples.
        """
    @property
    def shear_modulus(self) -> float:
        """
        Initial shear modulus [Pa].
        """
class Yeoh:
    """
    Yeoh's law: W = c1 (I1 - 3) + c2 (I1 - 3)^2 + c3 (I1 - 3)^3.
    
    Parameters
    ----------
    c1 : float
        Half the initial shear modulus [Pa], positive.
    c2 : float
        Coefficient of (I1 - 3)^2 [Pa].
    c3 : float
        Coefficient of (I1 - 3)^3 [Pa].
    density : float
        Density [kg/m^3].
    max_strain : float
        Largest nominal strain of the data behind the coefficients; 0 when not known. It judges results, it never
        changes them.
    
    Raises
    ------
    ValueError
        A value is not finite or breaks its rule, or the initial shear modulus 2 c1 is not positive.
    
    Notes
    -----
    Incompressible. Source: MECHANICS, "Material".
    """
    name: typing.ClassVar[str] = 'yeoh'
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> tuple[typing.Any, ...]:
        ...
    def __hash__(self) -> int:
        ...
    def __init__(self, *, c1: typing.SupportsFloat | typing.SupportsIndex, c2: typing.SupportsFloat | typing.SupportsIndex, c3: typing.SupportsFloat | typing.SupportsIndex = 0.0, density: typing.SupportsFloat | typing.SupportsIndex = 1080.0, max_strain: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: tuple[typing.Any, ...]) -> None:
        ...
    def check_drucker(self, max_strain: typing.SupportsFloat | typing.SupportsIndex | None = None) -> DruckerCheck:
        """
        Is the law stable in Drucker's sense in tension, planar tension and equibiaxial tension?
        
        Stable means that any further strain at constant volume costs work, d(stress) : d(strain) > 0.
        
        Parameters
        ----------
        max_strain : float, optional
            Nominal strains 0..max_strain are checked. Default: the law's own `max_strain`.
        
        Returns
        -------
        DruckerCheck
            True in a condition when stable; says where stability is lost first otherwise.
        
        Raises
        ------
        ValueError
            `max_strain` is not positive, or not given and not known to the law.
        """
    def energy_derivatives(self, a: typing.SupportsFloat | typing.SupportsIndex, t: typing.SupportsFloat | typing.SupportsIndex) -> tuple[float, float, float, float, float, float]:
        """
        Energy density and its derivatives (w, w_a, w_t, w_aa, w_at, w_tt) [Pa].
        
        Parameters
        ----------
        a : float
            Squared stretch in one principal direction.
        t : float
            Sum of the squared stretches in the other two, at least 2/sqrt(a).
        
        Raises
        ------
        ValueError
            `a` is not positive, or `t` too small to be a sum of real squares with product 1/a.
        """
    def energy_third_derivatives(self, a: typing.SupportsFloat | typing.SupportsIndex, t: typing.SupportsFloat | typing.SupportsIndex) -> tuple[float, float, float, float]:
        """
        Third derivatives (w_aaa, w_aat, w_att, w_ttt) [Pa]; arguments as in `energy_derivatives`.
        """
    @typing.overload
    def equibiaxial_stress(self, stretch: float) -> float:
        """
        Nominal stress in equibiaxial tension, in each of the two directions.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def equibiaxial_stress(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Nominal stress in equibiaxial tension, in each of the two directions.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def equibiaxial_tangent(self, stretch: float) -> float:
        """
        Derivative of the nominal stress in the stretch, in equibiaxial tension, in each of the two directions.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def equibiaxial_tangent(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Derivative of the nominal stress in the stretch, in equibiaxial tension, in each of the two directions.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def planar_stress(self, stretch: float) -> float:
        """
        Nominal stress in planar tension (pure shear: one lateral direction held).
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def planar_stress(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Nominal stress in planar tension (pure shear: one lateral direction held).
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def planar_tangent(self, stretch: float) -> float:
        """
        Derivative of the nominal stress in the stretch, in planar tension (pure shear: one lateral direction held).
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def planar_tangent(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Derivative of the nominal stress in the stretch, in planar tension (pure shear: one lateral direction held).
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def uniaxial_stress(self, stretch: float) -> float:
        """
        Nominal stress in uniaxial tension or compression.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def uniaxial_stress(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Nominal stress in uniaxial tension or compression.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def uniaxial_tangent(self, stretch: float) -> float:
        """
        Derivative of the nominal stress in the stretch, in uniaxial tension or compression.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def uniaxial_tangent(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Derivative of the nominal stress in the stretch, in uniaxial tension or compression.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @property
    def c1(self) -> float:
        """
        Half the initial shear modulus [Pa], positive.
        """
    @property
    def c2(self) -> float:
        """
        Coefficient of (I1 - 3)^2 [Pa].
        """
    @property
    def c3(self) -> float:
        """
        Coefficient of (I1 - 3)^3 [Pa].
        """
    @property
    def density(self) -> float:
        """
        Density [kg/m^3].
        """
    @property
    def max_strain(self) -> float:
        """
        Largest nominal strain of the fit range; 0 when not known.
        """
    @property
    def parameters(self) -> dict[str, typing.Any]:
        """
        Coefficients by name (a new dict); lists of coefficients are tuples.
        """
    @property
    def shear_modulus(self) -> float:
        """
        Initial shear modulus [Pa].
        """
class MooneyRivlin:
    """
    Mooney-Rivlin law: W = c10 (I1 - 3) + c01 (I2 - 3).
    
    Parameters
    ----------
    c10 : float
        Coefficient of I1 - 3 [Pa].
    c01 : float
        Coefficient of I2 - 3 [Pa].
    density : float
        Density [kg/m^3].
    max_strain : float
        Largest nominal strain of the data behind the coefficients; 0 when not known. It judges results, it never
        changes them.
    
    Raises
    ------
    ValueError
        A value is not finite or breaks its rule, or the initial shear modulus 2 (c10 + c01) is not positive.
    
    Notes
    -----
    Incompressible. Source: MECHANICS, "Material".
    """
    name: typing.ClassVar[str] = 'mooney-rivlin'
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> tuple[typing.Any, ...]:
        ...
    def __hash__(self) -> int:
        ...
    def __init__(self, *, c10: typing.SupportsFloat | typing.SupportsIndex, c01: typing.SupportsFloat | typing.SupportsIndex, density: typing.SupportsFloat | typing.SupportsIndex = 1080.0, max_strain: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: tuple[typing.Any, ...]) -> None:
        ...
    def check_drucker(self, max_strain: typing.SupportsFloat | typing.SupportsIndex | None = None) -> DruckerCheck:
        """
        Is the law stable in Drucker's sense in tension, planar tension and equibiaxial tension?
        
        Stable means that any further strain at constant volume costs work, d(stress) : d(strain) > 0.
        
        Parameters
        ----------
        max_strain : float, optional
            Nominal strains 0..max_strain are checked. Default: the law's own `max_strain`.
        
        Returns
        -------
        DruckerCheck
            True in a condition when stable; says where stability is lost first otherwise.
        
        Raises
        ------
        ValueError
            `max_strain` is not positive, or not given and not known to the law.
        """
    def energy_derivatives(self, a: typing.SupportsFloat | typing.SupportsIndex, t: typing.SupportsFloat | typing.SupportsIndex) -> tuple[float, float, float, float, float, float]:
        """
        Energy density and its derivatives (w, w_a, w_t, w_aa, w_at, w_tt) [Pa].
        
        Parameters
        ----------
        a : float
            Squared stretch in one principal direction.
        t : float
            Sum of the squared stretches in the other two, at least 2/sqrt(a).
        
        Raises
        ------
        ValueError
            `a` is not positive, or `t` too small to be a sum of real squares with product 1/a.
        """
    def energy_third_derivatives(self, a: typing.SupportsFloat | typing.SupportsIndex, t: typing.SupportsFloat | typing.SupportsIndex) -> tuple[float, float, float, float]:
        """
        Third derivatives (w_aaa, w_aat, w_att, w_ttt) [Pa]; arguments as in `energy_derivatives`.
        """
    @typing.overload
    def equibiaxial_stress(self, stretch: float) -> float:
        """
        Nominal stress in equibiaxial tension, in each of the two directions.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def equibiaxial_stress(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Nominal stress in equibiaxial tension, in each of the two directions.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def equibiaxial_tangent(self, stretch: float) -> float:
        """
        Derivative of the nominal stress in the stretch, in equibiaxial tension, in each of the two directions.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def equibiaxial_tangent(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Derivative of the nominal stress in the stretch, in equibiaxial tension, in each of the two directions.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def planar_stress(self, stretch: float) -> float:
        """
        Nominal stress in planar tension (pure shear: one lateral direction held).
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def planar_stress(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Nominal stress in planar tension (pure shear: one lateral direction held).
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def planar_tangent(self, stretch: float) -> float:
        """
        Derivative of the nominal stress in the stretch, in planar tension (pure shear: one lateral direction held).
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def planar_tangent(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Derivative of the nominal stress in the stretch, in planar tension (pure shear: one lateral direction held).
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def uniaxial_stress(self, stretch: float) -> float:
        """
        Nominal stress in uniaxial tension or compression.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def uniaxial_stress(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Nominal stress in uniaxial tension or compression.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def uniaxial_tangent(self, stretch: float) -> float:
        """
        Derivative of the nominal stress in the stretch, in uniaxial tension or compression.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def uniaxial_tangent(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Derivative of the nominal stress in the stretch, in uniaxial tension or compression.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @property
    def c01(self) -> float:
        """
        Coefficient of I2 - 3 [Pa].
        """
    @property
    def c10(self) -> float:
        """
        Coefficient of I1 - 3 [Pa].
        """
    @property
    def density(self) -> float:
        """
        Density [kg/m^3].
        """
    @property
    def max_strain(self) -> float:
        """
        Largest nominal strain of the fit range; 0 when not known.
        """
    @property
    def parameters(self) -> dict[str, typing.Any]:
        """
        Coefficients by name (a new dict); lists of coefficients are tuples.
        """
    @property
    def shear_modulus(self) -> float:
        """
        Initial shear modulus [Pa].
        """
class Ogden:
    """
    Ogden's law: W = sum mu_p/alpha_p (l1^alpha_p + l2^alpha_p + l3^alpha_p - 3).
    
    Parameters
    ----------
    mu : sequence of float
        Coefficients, one to four [Pa].
    alpha : sequence of float
        Exponents, as many, not zero, within [-50, 50].
    density : float
        Density [kg/m^3].
    max_strain : float
        Largest nominal strain of the data behind the coefficients; 0 when not known. It judges results, it never
        changes them.
    
    Raises
    ------
    ValueError
        A value is not finite or breaks its rule, or the initial shear modulus sum(mu alpha)/2 is not positive.
    
    Notes
    -----
    Incompressible. Source: MECHANICS, "Material".
    """
    name: typing.ClassVar[str] = 'ogden'
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> tuple[typing.Any, ...]:
        ...
    def __hash__(self) -> int:
        ...
    def __init__(self, *, mu: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], alpha: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], density: typing.SupportsFloat | typing.SupportsIndex = 1080.0, max_strain: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: tuple[typing.Any, ...]) -> None:
        ...
    def check_drucker(self, max_strain: typing.SupportsFloat | typing.SupportsIndex | None = None) -> DruckerCheck:
        """
        Is the law stable in Drucker's sense in tension, planar tension and equibiaxial tension?
        
        Stable means that any further strain at constant volume costs work, d(stress) : d(strain) > 0.
        
        Parameters
        ----------
        max_strain : float, optional
            Nominal strains 0..max_strain are checked. Default: the law's own `max_strain`.
        
        Returns
        -------
        DruckerCheck
            True in a condition when stable; says where stability is lost first otherwise.
        
        Raises
        ------
        ValueError
            `max_strain` is not positive, or not given and not known to the law.
        """
    def energy_derivatives(self, a: typing.SupportsFloat | typing.SupportsIndex, t: typing.SupportsFloat | typing.SupportsIndex) -> tuple[float, float, float, float, float, float]:
        """
        Energy density and its derivatives (w, w_a, w_t, w_aa, w_at, w_tt) [Pa].
        
        Parameters
        ----------
        a : float
            Squared stretch in one principal direction.
        t : float
            Sum of the squared stretches in the other two, at least 2/sqrt(a).
        
        Raises
        ------
        ValueError
            `a` is not positive, or `t` too small to be a sum of real squares with product 1/a.
        """
    def energy_third_derivatives(self, a: typing.SupportsFloat | typing.SupportsIndex, t: typing.SupportsFloat | typing.SupportsIndex) -> tuple[float, float, float, float]:
        """
        Third derivatives (w_aaa, w_aat, w_att, w_ttt) [Pa]; arguments as in `energy_derivatives`.
        """
    @typing.overload
    def equibiaxial_stress(self, stretch: float) -> float:
        """
        Nominal stress in equibiaxial tension, in each of the two directions.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def equibiaxial_stress(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Nominal stress in equibiaxial tension, in each of the two directions.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def equibiaxial_tangent(self, stretch: float) -> float:
        """
        Derivative of the nominal stress in the stretch, in equibiaxial tension, in each of the two directions.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def equibiaxial_tangent(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Derivative of the nominal stress in the stretch, in equibiaxial tension, in each of the two directions.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def planar_stress(self, stretch: float) -> float:
        """
        Nominal stress in planar tension (pure shear: one lateral direction held).
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def planar_stress(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Nominal stress in planar tension (pure shear: one lateral direction held).
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def planar_tangent(self, stretch: float) -> float:
        """
        Derivative of the nominal stress in the stretch, in planar tension (pure shear: one lateral direction held).
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def planar_tangent(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Derivative of the nominal stress in the stretch, in planar tension (pure shear: one lateral direction held).
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def uniaxial_stress(self, stretch: float) -> float:
        """
        Nominal stress in uniaxial tension or compression.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def uniaxial_stress(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Nominal stress in uniaxial tension or compression.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def uniaxial_tangent(self, stretch: float) -> float:
        """
        Derivative of the nominal stress in the stretch, in uniaxial tension or compression.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def uniaxial_tangent(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Derivative of the nominal stress in the stretch, in uniaxial tension or compression.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @property
    def alpha(self) -> tuple[float, ...]:
        """
        Exponents, as many, not zero, within [-50, 50].
        """
    @property
    def density(self) -> float:
        """
        Density [kg/m^3].
        """
    @property
    def max_strain(self) -> float:
        """
        Largest nominal strain of the fit range; 0 when not known.
        """
    @property
    def mu(self) -> tuple[float, ...]:
        """
        Coefficients, one to four [Pa].
        """
    @property
    def parameters(self) -> dict[str, typing.Any]:
        """
        Coefficients by name (a new dict); lists of coefficients are tuples.
        """
    @property
    def shear_modulus(self) -> float:
        """
        Initial shear modulus [Pa].
        """
class Gent:
    """
    Gent's law: W = -(mu jm/2) log(1 - (I1 - 3)/jm); NaN at and past I1 - 3 = jm.
    
    Parameters
    ----------
    mu : float
        Initial shear modulus [Pa], positive.
    jm : float
        Value of I1 - 3 that no state can reach, positive.
    density : float
        Density [kg/m^3].
    max_strain : float
        Largest nominal strain of the data behind the coefficients; 0 when not known. It judges results, it never
        changes them.
    
    Raises
    ------
    ValueError
        A value is not finite or breaks its rule, or the initial shear modulus mu is not positive.
    
    Notes
    -----
    Incompressible. Source: MECHANICS, "Material".
    """
    name: typing.ClassVar[str] = 'gent'
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> tuple[typing.Any, ...]:
        ...
    def __hash__(self) -> int:
        ...
    def __init__(self, *, mu: typing.SupportsFloat | typing.SupportsIndex, jm: typing.SupportsFloat | typing.SupportsIndex, density: typing.SupportsFloat | typing.SupportsIndex = 1080.0, max_strain: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: tuple[typing.Any, ...]) -> None:
        ...
    def check_drucker(self, max_strain: typing.SupportsFloat | typing.SupportsIndex | None = None) -> DruckerCheck:
        """
        Is the law stable in Drucker's sense in tension, planar tension and equibiaxial tension?
        
        Stable means that any further strain at constant volume costs work, d(stress) : d(strain) > 0.
        
        Parameters
        ----------
        max_strain : float, optional
            Nominal strains 0..max_strain are checked. Default: the law's own `max_strain`.
        
        Returns
        -------
        DruckerCheck
            True in a condition when stable; says where stability is lost first otherwise.
        
        Raises
        ------
        ValueError
            `max_strain` is not positive, or not given and not known to the law.
        """
    def energy_derivatives(self, a: typing.SupportsFloat | typing.SupportsIndex, t: typing.SupportsFloat | typing.SupportsIndex) -> tuple[float, float, float, float, float, float]:
        """
        Energy density and its derivatives (w, w_a, w_t, w_aa, w_at, w_tt) [Pa].
        
        Parameters
        ----------
        a : float
            Squared stretch in one principal direction.
        t : float
            Sum of the squared stretches in the other two, at least 2/sqrt(a).
        
        Raises
        ------
        ValueError
            `a` is not positive, or `t` too small to be a sum of real squares with product 1/a.
        """
    def energy_third_derivatives(self, a: typing.SupportsFloat | typing.SupportsIndex, t: typing.SupportsFloat | typing.SupportsIndex) -> tuple[float, float, float, float]:
        """
        Third derivatives (w_aaa, w_aat, w_att, w_ttt) [Pa]; arguments as in `energy_derivatives`.
        """
    @typing.overload
    def equibiaxial_stress(self, stretch: float) -> float:
        """
        Nominal stress in equibiaxial tension, in each of the two directions.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def equibiaxial_stress(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Nominal stress in equibiaxial tension, in each of the two directions.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def equibiaxial_tangent(self, stretch: float) -> float:
        """
        Derivative of the nominal stress in the stretch, in equibiaxial tension, in each of the two directions.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def equibiaxial_tangent(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Derivative of the nominal stress in the stretch, in equibiaxial tension, in each of the two directions.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def planar_stress(self, stretch: float) -> float:
        """
        Nominal stress in planar tension (pure shear: one lateral direction held).
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def planar_stress(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Nominal stress in planar tension (pure shear: one lateral direction held).
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def planar_tangent(self, stretch: float) -> float:
        """
        Derivative of the nominal stress in the stretch, in planar tension (pure shear: one lateral direction held).
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def planar_tangent(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Derivative of the nominal stress in the stretch, in planar tension (pure shear: one lateral direction held).
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def uniaxial_stress(self, stretch: float) -> float:
        """
        Nominal stress in uniaxial tension or compression.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def uniaxial_stress(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Nominal stress in uniaxial tension or compression.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def uniaxial_tangent(self, stretch: float) -> float:
        """
        Derivative of the nominal stress in the stretch, in uniaxial tension or compression.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @typing.overload
    def uniaxial_tangent(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Derivative of the nominal stress in the stretch, in uniaxial tension or compression.
        
        Parameters
        ----------
        stretch : float or array_like
            Stretch, positive.
        
        Returns
        -------
        float or ndarray of the same shape
            [Pa]; NaN where the law has no value (Gent past its limit).
        
        Raises
        ------
        ValueError
            A stretch is not finite or not positive.
        """
    @property
    def density(self) -> float:
        """
        Density [kg/m^3].
        """
    @property
    def jm(self) -> float:
        """
        Value of I1 - 3 that no state can reach, positive.
        """
    @property
    def max_strain(self) -> float:
        """
        Largest nominal strain of the fit range; 0 when not known.
        """
    @property
    def mu(self) -> float:
        """
        Initial shear modulus [Pa], positive.
        """
    @property
    def parameters(self) -> dict[str, typing.Any]:
        """
        Coefficients by name (a new dict); lists of coefficients are tuples.
        """
    @property
    def shear_modulus(self) -> float:
        """
        Initial shear modulus [Pa].
        """
class Fibres:
    """
    One family of parallel fibres, spread evenly over its layer.
    
    Its energy per volume of the layer is ``k (stretch - 1)^2 / 2``. Source: MECHANICS, "Actuator".
    
    Parameters
    ----------
    angle : float
        From the circumferential direction, within [-pi/2, pi/2] [rad].
    stiffness : float, optional
        k itself [Pa]; the silicone is then left whole.
    modulus, fraction : float, optional
        Modulus of the thread [Pa] and its share of the layer's volume: ``k = modulus * fraction``, and the silicone
        counts ``1 - sum of fractions``.
    
    Raises
    ------
    ValueError
        An angle beyond a right angle, a negative stiffness, a fraction outside [0, 1], or both ways at once.
    """
    @staticmethod
    def pair(*, angle: typing.SupportsFloat | typing.SupportsIndex, stiffness: typing.SupportsFloat | typing.SupportsIndex | None = None, modulus: typing.SupportsFloat | typing.SupportsIndex | None = None, fraction: typing.SupportsFloat | typing.SupportsIndex | None = None) -> list[Fibres]:
        """
        Two families at ``+angle`` and ``-angle``; stiffness or fraction are those of each family.
        """
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> tuple[typing.Any, ...]:
        ...
    def __hash__(self) -> int:
        ...
    def __init__(self, *, angle: typing.SupportsFloat | typing.SupportsIndex, stiffness: typing.SupportsFloat | typing.SupportsIndex | None = None, modulus: typing.SupportsFloat | typing.SupportsIndex | None = None, fraction: typing.SupportsFloat | typing.SupportsIndex | None = None) -> None:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: tuple[typing.Any, ...]) -> None:
        ...
    @property
    def angle(self) -> float:
        """
        From the circumferential direction [rad].
        """
    @property
    def fraction(self) -> float:
        """
        Share of the layer's volume; 0 leaves the silicone whole.
        """
    @property
    def modulus(self) -> float | None:
        """
        Modulus of the thread [Pa]; None when the stiffness was given.
        """
    @property
    def stiffness(self) -> float:
        """
        k [Pa].
        """
class Layer:
    """
    One layer of a tube.
    
    Parameters
    ----------
    inner, outer : float
        Undeformed radii [m].
    law : NeoHookean, Yeoh, MooneyRivlin, Ogden or Gent
        Material law of the silicone.
    fibres : Fibres or sequence of Fibres, optional
        Families in this layer.
    
    Raises
    ------
    ValueError
        Radii that are not positive or out of order, or fractions that leave no silicone.
    """
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> tuple[typing.Any, ...]:
        ...
    def __hash__(self) -> int:
        ...
    def __init__(self, inner: typing.SupportsFloat | typing.SupportsIndex, outer: typing.SupportsFloat | typing.SupportsIndex, law: NeoHookean | Yeoh | MooneyRivlin | Ogden | Gent, fibres: collections.abc.Sequence[Fibres] | Fibres = []) -> None:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: tuple[typing.Any, ...]) -> None:
        ...
    @property
    def fibres(self) -> list[Fibres]:
        """
        Fibre families (a new list).
        """
    @property
    def inner(self) -> float:
        """
        Undeformed inner radius [m].
        """
    @property
    def law(self) -> NeoHookean | Yeoh | MooneyRivlin | Ogden | Gent:
        """
        Material law of the silicone.
        """
    @property
    def outer(self) -> float:
        """
        Undeformed outer radius [m].
        """
    @property
    def silicone_fraction(self) -> float:
        """
        1 - sum of the fibre fractions.
        """
class TubeStates:
    """
    States of a tube, one a solve; arrays in the order of the solves.
    """
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> bytes:
        ...
    def __hash__(self) -> int:
        ...
    def __len__(self) -> int:
        ...
    def __setstate__(self, arg0: bytes) -> None:
        ...
    def model(self, index: typing.SupportsInt | typing.SupportsIndex) -> str:
        ...
    def one(self, index: typing.SupportsInt | typing.SupportsIndex) -> TubeStates:
        ...
    def status(self, index: typing.SupportsInt | typing.SupportsIndex) -> str:
        ...
    @property
    def axial_force(self) -> numpy.typing.NDArray[numpy.float64]:
        ...
    @property
    def flags(self) -> numpy.typing.NDArray[numpy.uint32]:
        ...
    @property
    def inner_radius(self) -> numpy.typing.NDArray[numpy.float64]:
        ...
    @property
    def iterations(self) -> numpy.typing.NDArray[numpy.int32]:
        ...
    @property
    def limit_pressure(self) -> numpy.typing.NDArray[numpy.float64]:
        ...
    @property
    def pressure(self) -> numpy.typing.NDArray[numpy.float64]:
        ...
    @property
    def smallest_eigenvalue(self) -> numpy.typing.NDArray[numpy.float64]:
        ...
    @property
    def stable(self) -> numpy.typing.NDArray[numpy.bool]:
        ...
    @property
    def stretch(self) -> numpy.typing.NDArray[numpy.float64]:
        ...
    @property
    def success(self) -> numpy.typing.NDArray[numpy.bool]:
        ...
    @property
    def torque(self) -> numpy.typing.NDArray[numpy.float64]:
        ...
    @property
    def twist_rate(self) -> numpy.typing.NDArray[numpy.float64]:
        ...
class ThreadGeometry:
    """
    Angle and volume fraction of a wound thread, for one family.
    """
    @property
    def angle(self) -> float:
        """
        From the circumferential direction [rad].
        """
    @property
    def fraction(self) -> float:
        """
        Thread over layer, by volume.
        """
class Tube:
    """
    A fibre-reinforced tube; see softlimb.Tube.
    """
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __hash__(self) -> int:
        ...
    def __init__(self, *, length: typing.SupportsFloat | typing.SupportsIndex, layers: collections.abc.Sequence[Layer], tension_only: bool = False, ends: str = 'free', mass: typing.SupportsFloat | typing.SupportsIndex | None = None, cap_length: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def _at_stretch(self, stretch: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> TubeStates:
        ...
    def _at_volume(self, value: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], is_radius: bool, axial_force: typing.SupportsFloat | typing.SupportsIndex, torque: typing.SupportsFloat | typing.SupportsIndex) -> TubeStates:
        ...
    def _energy(self, stretch: typing.SupportsFloat | typing.SupportsIndex, volume: typing.SupportsFloat | typing.SupportsIndex, twist: typing.SupportsFloat | typing.SupportsIndex) -> list[float]:
        """
        Scaled wall energy with gradient (l, w, t) and Hessian (ll, lw, lt, ww, wt, tt) [Pa], for tests.
        """
    def _fibres(self, states: TubeStates) -> list[tuple[int, float, float, float, float, float]]:
        ...
    def _inflate(self, pressure: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], axial_force: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], torque: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], reduced: bool) -> TubeStates:
        ...
    def _message(self, states: TubeStates, index: typing.SupportsInt | typing.SupportsIndex) -> str:
        ...
    def _other_pressures(self, stretch: typing.SupportsFloat | typing.SupportsIndex) -> list[float]:
        ...
    def _outer_radius(self, states: TubeStates) -> numpy.typing.NDArray[numpy.float64]:
        ...
    def _remarks(self, states: TubeStates, index: typing.SupportsInt | typing.SupportsIndex) -> list[str]:
        ...
    def _section(self, pressure: typing.SupportsFloat | typing.SupportsIndex, model: str, valve: str, derivative: bool) -> dict[str, typing.Any]:
        ...
    def _section_slope(self, pressure: typing.SupportsFloat | typing.SupportsIndex, model: str, valve: str, parameter: str, layer: typing.SupportsInt | typing.SupportsIndex, number: typing.SupportsInt | typing.SupportsIndex, twin: typing.SupportsInt | typing.SupportsIndex) -> tuple[float, Section]:
        """
        Derivative of rest length and section to one number of the tube.
        """
    def _stress(self, states: TubeStates, radius: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], is_reference: bool) -> numpy.typing.NDArray[numpy.float64]:
        ...
    @property
    def cap_length(self) -> float:
        """
        Length at each end that a rigid cap keeps at rest [m].
        """
    @property
    def ends(self) -> str:
        """
        ``free``, or ``bonded``: twist blocked.
        """
    @property
    def inner_radius(self) -> float:
        """
        Undeformed inner radius [m].
        """
    @property
    def layers(self) -> list[Layer]:
        """
        Layers from inside out (a new list).
        """
    @property
    def length(self) -> float:
        """
        Length at zero pressure [m].
        """
    @property
    def limit_pressure(self) -> float | None:
        """
        Pressure at which the unloaded tube balloons or else loses stability [Pa]; None when there is none in reach (stretches to 4).
        """
    @property
    def locking_share(self) -> float:
        """
        Share of the work of a first small pressure that two-way fibres smeared over a layer spend against each other. Above 0.1 a state says that they lock.
        """
    @property
    def mass(self) -> float:
        """
        [kg]
        """
    @property
    def outer_radius(self) -> float:
        """
        Undeformed outer radius [m].
        """
    @property
    def tension_only(self) -> bool:
        """
        True when fibres carry no compression.
        """
class Posture:
    """
    A solved limb: shape, wrenches, outcome.
    """
    def __getstate__(self) -> tuple[typing.Any, ...]:
        ...
    def __setstate__(self, arg0: tuple[typing.Any, ...]) -> None:
        ...
    def clearance(self, arg0: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], arg1: typing.SupportsInt | typing.SupportsIndex) -> tuple[float, int, int, float, float]:
        ...
    def remarks(self, gap: typing.SupportsFloat | typing.SupportsIndex, first: typing.SupportsInt | typing.SupportsIndex) -> list[str]:
        """
        What to know before the posture is trusted; of its clearance.
        """
    def rod(self, rod: typing.SupportsInt | typing.SupportsIndex, fractions: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex]) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]:
        """
        Poses (n,4,4), forces, moments, strains, curvatures (n,3) of rod number `rod` at fractions of its length.
        """
    def rod_base_wrench(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float64]:
        ...
    def verify(self) -> tuple[float, float, float, float, float]:
        ...
    @property
    def base_wrench(self) -> numpy.typing.NDArray[numpy.float64]:
        ...
    @property
    def conservative(self) -> bool:
        ...
    @property
    def descent_iterations(self) -> int:
        ...
    @property
    def elements(self) -> list[int]:
        ...
    @property
    def error_estimate(self) -> float:
        ...
    @property
    def followed(self) -> bool:
        """
        Solved from a posture near by, and linearised at the answer.
        """
    @property
    def iterations(self) -> int:
        ...
    @property
    def message(self) -> str:
        ...
    @property
    def plan(self) -> list[str]:
        ...
    @property
    def plates(self) -> numpy.typing.NDArray[numpy.float64]:
        ...
    @property
    def pressures(self) -> numpy.typing.NDArray[numpy.float64] | None:
        """
        Of the actuators, where the rods came from pressures [Pa].
        """
    @property
    def reactions(self) -> numpy.typing.NDArray[numpy.float64]:
        ...
    @property
    def residual(self) -> float:
        ...
    @property
    def scene(self) -> Scene:
        ...
    @property
    def stable(self) -> bool:
        ...
    @property
    def status(self) -> str:
        ...
    @property
    def unstable_modes(self) -> int | None:
        ...
class Scene:
    """
    Rods at their pressures, loads and holds of one solve.
    """
    @property
    def following(self) -> bool:
        ...
    @property
    def gravity(self) -> numpy.typing.NDArray[numpy.float64]:
        ...
    @property
    def rest_lengths(self) -> list[float]:
        ...
    @property
    def sections(self) -> list[Section]:
        ...
    @property
    def wrenches(self) -> numpy.typing.NDArray[numpy.float64]:
        ...
class Geometry:
    """
    Placement of rods and plates of a limb; constant and shared.
    """
    def __getstate__(self) -> tuple[typing.Any, ...]:
        ...
    def __init__(self, segments: collections.abc.Sequence[tuple[typing.Annotated[numpy.typing.ArrayLike, numpy.float64], typing.Annotated[numpy.typing.ArrayLike, numpy.float64], typing.SupportsFloat | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex]], length: typing.SupportsFloat | typing.SupportsIndex) -> None:
        ...
    def __setstate__(self, arg0: tuple[typing.Any, ...]) -> None:
        ...
    def refused(self, scene: Scene, *, status: str, message: str) -> Posture:
        """
        Posture of a scene that cannot be solved, with the reason.
        """
    def scene(self, *, sections: collections.abc.Sequence[Section], rest_lengths: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], gravity: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], wrenches: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], following: bool, line_forces: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], line_moments: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], held: typing.Annotated[numpy.typing.ArrayLike, numpy.bool], hold_poses: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> Scene:
        """
        Scene of one solve; arrays as in Limb.solve, all given.
        """
    def solve(self, scene: Scene, *, tolerance: typing.SupportsFloat | typing.SupportsIndex, prefer_stable: bool, start: Posture | None, start_plates: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] | None) -> Posture:
        """
        Equilibrium of the scene.
        """
    def start_plates(self, scene: Scene) -> numpy.typing.NDArray[numpy.float64]:
        """
        Plates under constant curvature, unloaded: where a solve without a start begins.
        """
    @property
    def length(self) -> float:
        """
        Reference length [m]
        """
class Members:
    """
    What a limb is made of: tubes, or rods as (section, length, radius) with radius 0 where it is not known; flat order.
    """
    def __init__(self, members: collections.abc.Sequence[Tube | tuple[Section, typing.SupportsFloat | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex]]) -> None:
        ...
    def at_pressures(self, pressures: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], section: str, valve: str) -> tuple[list[Section], numpy.typing.NDArray[numpy.float64], tuple[str, str] | None]:
        """
        Sections, rest lengths, and status and reason where an actuator has no state.
        """
class PlainSolver:
    """
    Postures from plain numbers, in a few microseconds beside the solve.
    """
    def __init__(self, geometry: Geometry, members: Members, actuators_of_segments: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex]) -> None:
        ...
    def loads(self, gravity: typing.Any, tip_force: typing.Any, tip_moment: typing.Any, frame: typing.Any) -> Scene | None:
        """
        A scene with these loads and neither sections nor lengths; None where one is not plain.
        """
    def solve(self, pressures: typing.Any, rest_lengths: typing.Any, gravity: typing.Any, tip_force: typing.Any, tip_moment: typing.Any, frame: typing.Any, tolerance: typing.Any, start: typing.Any, prefer_stable: typing.Any, section: typing.Any, valve: typing.Any) -> Posture | None:
        """
        Arguments of Limb.solve, positional, `start` a core Posture or None. None where one is not plain or has
        no answer: it is then for Python to say what is wrong. Plain are floats and integers, lists and tuples of them, arrays
        of float64; all finite and of the right number.
        """
class Parameters:
    """
    Numbers of a limb and its loads for derivatives: kind, place, layer, number, twin, direction, column and
    factor each.
    """
    def __init__(self, parameters: collections.abc.Sequence[tuple[str, typing.SupportsInt | typing.SupportsIndex, typing.SupportsInt | typing.SupportsIndex, typing.SupportsInt | typing.SupportsIndex, typing.SupportsInt | typing.SupportsIndex, collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex] | None, typing.SupportsInt | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex]], columns: typing.SupportsInt | typing.SupportsIndex) -> None:
        ...
class Derivatives:
    """
    A posture, linearised. `made` is (members, pressures, section model, valve).
    """
    def adjoint(self, weights: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], parameters: Parameters, made: tuple[Members, typing.Annotated[numpy.typing.ArrayLike, numpy.float64], str, str], rods: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], fractions: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Rows of weights times what `forward` gives, without forming it.
        """
    def compliance(self) -> numpy.typing.NDArray[numpy.float64]:
        ...
    def forward(self, parameters: Parameters, made: tuple[Members, typing.Annotated[numpy.typing.ArrayLike, numpy.float64], str, str], rods: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], fractions: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex]) -> numpy.typing.NDArray[numpy.float64]:
        """
        (dp, dtheta) of all plates, then positions of points on rods, by each column.
        """
    def plate_stiffness(self) -> numpy.typing.NDArray[numpy.float64]:
        ...
    def tip_by_pressures(self, made: tuple[Members, typing.Annotated[numpy.typing.ArrayLike, numpy.float64], str, str]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Tip (dp, dtheta) by each pressure, (6, actuators).
        """
class FollowedPath:
    """
    Equilibria along one parameter.
    """
    def __init__(self) -> None:
        """
        A path without points.
        """
    def between(self, after: typing.SupportsInt | typing.SupportsIndex, parameter: typing.SupportsFloat | typing.SupportsIndex) -> list[Posture]:
        """
        Postures at a parameter between points `after` and `after` + 1.
        """
    def event_posture(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> Posture:
        ...
    def posture(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> Posture:
        ...
    @property
    def arclengths(self) -> list[float]:
        ...
    @property
    def end(self) -> str:
        ...
    @property
    def events(self) -> list[tuple[str, int, float]]:
        ...
    @property
    def parameters(self) -> list[float]:
        ...
class Reached:
    """
    Pressures for a target, and their posture.
    """
    @property
    def another_from_nothing(self) -> bool:
        ...
    @property
    def gap(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        Tip minus target [m], rotation vector from the target to the tip [rad], shape (6,).
        """
    @property
    def iterations(self) -> int:
        ...
    @property
    def least(self) -> bool:
        ...
    @property
    def lower(self) -> numpy.typing.NDArray[numpy.float64]:
        ...
    @property
    def posture(self) -> Posture:
        ...
    @property
    def reached(self) -> bool:
        ...
    @property
    def starts(self) -> int:
        ...
    @property
    def status(self) -> str:
        ...
    @property
    def target(self) -> numpy.typing.NDArray[numpy.float64]:
        ...
    @property
    def upper(self) -> numpy.typing.NDArray[numpy.float64]:
        ...
    @property
    def weights(self) -> numpy.typing.NDArray[numpy.float64]:
        ...
class Atlas:
    """
    Starts for the rows of a long sweep, fitted to some of them; made by `survey_rows`.
    """
    def __getstate__(self) -> tuple[list[int], list[int], list[int], list[float], list[float], list[float], list[tuple[list[int], list[int], list[float]]]]:
        ...
    def __setstate__(self, arg0: tuple[collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], collections.abc.Sequence[tuple[collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex]]]]) -> None:
        ...
    @property
    def terms(self) -> list[int]:
        """
        Numbers of terms of the polynomials of its segments.
        """
class Pid:
    """
    The PID of softlimb/control/pid.hpp; see `softlimb.control.PID`.
    """
    def __init__(self, *, weights: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], period: typing.SupportsFloat | typing.SupportsIndex, scale: typing.SupportsFloat | typing.SupportsIndex, limits: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(2)"], sign: str, anti_windup: str, tracking_time: typing.SupportsFloat | typing.SupportsIndex, filter_time: typing.SupportsFloat | typing.SupportsIndex) -> None:
        ...
    def reset(self) -> None:
        """
        Forgets what was seen.
        """
    def step(self, target: typing.SupportsFloat | typing.SupportsIndex, measured: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        The next command.
        """
    @property
    def inputs(self) -> typing.Annotated[list[float], "FixedSize(3)"]:
        """
        x1, x2, x3 of the last step.
        """
    @property
    def weights(self) -> typing.Annotated[list[float], "FixedSize(3)"]:
        """
        w1, w2, w3.
        """
class NeuralPid:
    """
    The neural PID of softlimb/control/neural_pid.hpp; see `softlimb.control.NeuralPID`.
    """
    def __init__(self, *, weights: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], period: typing.SupportsFloat | typing.SupportsIndex, scale: typing.SupportsFloat | typing.SupportsIndex, limits: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(2)"], sign: str, anti_windup: str, tracking_time: typing.SupportsFloat | typing.SupportsIndex, filter_time: typing.SupportsFloat | typing.SupportsIndex, learning: str, slope: str, rates: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], lowest: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], highest: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], epsilon: typing.SupportsFloat | typing.SupportsIndex, slope_limits: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(2)"], smallest_move: typing.SupportsFloat | typing.SupportsIndex) -> None:
        ...
    def reset(self) -> None:
        """
        Back to the first weights, and forgets what was seen.
        """
    def step(self, target: typing.SupportsFloat | typing.SupportsIndex, measured: typing.SupportsFloat | typing.SupportsIndex, slope: typing.SupportsFloat | typing.SupportsIndex = 1.0) -> float:
        """
        The next command; then the weights learn.
        """
    @property
    def inputs(self) -> typing.Annotated[list[float], "FixedSize(3)"]:
        """
        x1, x2, x3 of the last step.
        """
    @property
    def weights(self) -> typing.Annotated[list[float], "FixedSize(3)"]:
        """
        w1, w2, w3 as learned.
        """
class Plant:
    """
    Pump, reservoir, valves, lines and chambers; see `softlimb.control.Pneumatics`.
    """
    def __copy__(self) -> Plant:
        ...
    def __init__(self, *, gas: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(5)"], supply: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(4)"], channels: collections.abc.Sequence[tuple[typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(7)"], typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(2)"], typing.SupportsFloat | typing.SupportsIndex, collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], tuple[typing.SupportsFloat | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex, typing.SupportsInt | typing.SupportsIndex]]], period: typing.SupportsFloat | typing.SupportsIndex, substeps: typing.SupportsInt | typing.SupportsIndex, seed: typing.SupportsInt | typing.SupportsIndex) -> None:
        ...
    def advance(self, commands: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> bool:
        """
        One period under these commands; False where the implicit step did not converge.
        """
    def read(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        Readings of the sensors [Pa], shape (A,).
        """
    def set_dumped(self, dumped: bool) -> None:
        """
        Cuts the supply off and opens every line to the atmosphere, or ends that.
        """
    def set_leak(self, channel: typing.SupportsInt | typing.SupportsIndex, conductance: typing.SupportsFloat | typing.SupportsIndex) -> None:
        """
        Orifice from a chamber to the atmosphere [m^3/(s Pa)].
        """
    def set_sensor(self, channel: typing.SupportsInt | typing.SupportsIndex, *, fault: str = 'none', bias: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        """
        A sensor without reading, or that repeats its last one; a bias [Pa].
        """
    def set_supply(self, *, pump_share: typing.SupportsFloat | typing.SupportsIndex = 1.0, leak: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        """
        Share of the pump's flow that is left, and an orifice from the reservoir [m^3/(s Pa)].
        """
    def set_valve_stuck(self, channel: typing.SupportsInt | typing.SupportsIndex, stuck: bool) -> None:
        """
        The spool stays where it is.
        """
    def set_volume_scale(self, channel: typing.SupportsInt | typing.SupportsIndex, scale: typing.SupportsFloat | typing.SupportsIndex) -> None:
        """
        Chamber volume over what its table says.
        """
    @property
    def beyond_table(self) -> list[bool]:
        """
        Which chambers were ever above the last pressure of their volume table.
        """
    @property
    def ledger(self) -> dict[str, float]:
        """
        Air at the start, stored now, pumped in, lost to the atmosphere, drawn by the lines [kg].
        """
    @property
    def line_pressures(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        Gauge pressures of the lines [Pa], shape (A,).
        """
    @property
    def mass_defect(self) -> float:
        """
        Largest relative difference of a mass from what its pressure says.
        """
    @property
    def openings(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        Openings of the valves, -1 to 1, shape (A,).
        """
    @property
    def period(self) -> float:
        """
        Of a step [s].
        """
    @property
    def pressures(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        Gauge pressures of the chambers [Pa], shape (A,).
        """
    @property
    def supply_pressure(self) -> float:
        """
        Gauge pressure of the reservoir [Pa].
        """
    @property
    def volumes(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        Volumes of the chambers [m^3], shape (A,).
        """
class PressureLoop:
    """
    Controllers and guards against a plant, which it keeps a copy of.
    """
    def __init__(self, plant: Plant, controllers: list[typing.Any], guards: tuple[typing.SupportsInt | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex, typing.SupportsInt | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex, typing.SupportsInt | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex, typing.SupportsInt | typing.SupportsIndex, typing.SupportsFloat | typing.SupportsIndex, typing.SupportsInt | typing.SupportsIndex] | None) -> None:
        ...
    def run(self, targets: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], *, timed: bool = False) -> dict[str, typing.Any]:
        """
        One period a row of targets (N, A) [Pa]; arrays by name.
        """
    def vent(self) -> None:
        """
        Ends control: exhaust commands and dump valves.
        """
    @property
    def faults(self) -> list[tuple[int, str, int]]:
        """
        Channel, name and step of what ended control.
        """
    @property
    def plant(self) -> Plant:
        """
        The plant, to disturb and to look at.
        """
    @property
    def steps(self) -> int:
        """
        Periods run so far.
        """
    @property
    def vented(self) -> bool:
        """
        Control has ended.
        """
def axial_strain(section: Section, force: typing.SupportsFloat | typing.SupportsIndex) -> tuple[float, float]:
    """
    Strain v3 - 1 and its derivative to the force [1/N] of a section's axial law at a force [N], without end moment.
    """
def axial_strain_slope(section: Section, slope: Section, force: typing.SupportsFloat | typing.SupportsIndex) -> float:
    """
    Derivative of the strain v3 - 1 at a force [N] to what the section has this derivative to.
    """
def build_info() -> dict[str, str]:
    """
    Compiler, flags, language standard, target and assertions of this build, as texts.
    """
def follow(geometry: Geometry, scene_at: collections.abc.Callable[[float], Scene | None], first: Posture, *, start: typing.SupportsFloat | typing.SupportsIndex, stop: typing.SupportsFloat | typing.SupportsIndex, tolerance: typing.SupportsFloat | typing.SupportsIndex, largest_step: typing.SupportsFloat | typing.SupportsIndex, max_points: typing.SupportsInt | typing.SupportsIndex, through_events: bool) -> FollowedPath:
    """
    Follows the equilibrium `first`; scene_at(parameter) gives a Scene, or None where there is none.
    """
def instruction_set() -> str:
    """
    Instruction set that the rods are integrated with: baseline, avx2 or avx512.
    """
def instruction_sets() -> list[str]:
    """
    Those that this machine has, plainest first.
    """
def integrator_orders() -> list[int]:
    """
    Orders of the integrators in the list.
    """
def law_class_names() -> list[str]:
    """
    Class names of the material laws, in the order of the list in laws.hpp.
    """
def law_coefficients(law: NeoHookean | Yeoh | MooneyRivlin | Ogden | Gent) -> list[str]:
    """
    Names of all coefficients of a law.
    """
def linearised(posture: Posture, tolerance: typing.SupportsFloat | typing.SupportsIndex) -> Derivatives:
    """
    RuntimeError at a fold.
    """
def orifice_flow(conductance: typing.SupportsFloat | typing.SupportsIndex, critical_ratio: typing.SupportsFloat | typing.SupportsIndex, first: typing.SupportsFloat | typing.SupportsIndex, second: typing.SupportsFloat | typing.SupportsIndex) -> tuple[float, float, float]:
    """
    ISO 6358: mass flow [kg/s] between absolute pressures [Pa], and its derivatives to both.
    """
def plain_reach(geometry: Geometry, members: Members, scene: Scene, position: typing.Any, pose: typing.Any, max_pressure: typing.Any, tolerance: typing.Any, section: typing.Any, valve: typing.Any, start: typing.Any) -> Reached | None:
    """
    Arguments of Limb.reach as they come, `start` a core Posture, Reached or None. None where one is not plain or
    not right: it is then for Python to say what is wrong.
    """
def potential_energy(posture: Posture) -> float:
    """
    Of rods and loads [J]; RuntimeError where the loads have no potential.
    """
def potential_energy_slopes(posture: Posture, parameters: Parameters, made: tuple[Members, typing.Annotated[numpy.typing.ArrayLike, numpy.float64], str, str]) -> numpy.typing.NDArray[numpy.float64]:
    """
    Its derivatives, (columns,).
    """
def reach(geometry: Geometry, members: Members, scene: Scene, *, target: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], weights: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], lower: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], upper: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], preferred: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], tolerance: typing.SupportsFloat | typing.SupportsIndex, section: str, valve: str, start: Posture | None, start_pressures: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] | None, learned: Reached | None, starts: typing.SupportsInt | typing.SupportsIndex) -> Reached:
    """
    Pressures within bounds (one number an actuator [Pa]) that put the tip on the target pose (4, 4), errors
    counted by six weights; of the scene only loads and holds count.
    """
def rest_length_slopes(posture: Posture, parameters: Parameters, made: tuple[Members, typing.Annotated[numpy.typing.ArrayLike, numpy.float64], str, str]) -> numpy.typing.NDArray[numpy.float64]:
    """
    Rest lengths by parameters, (rods, columns).
    """
def rod_end(section: Section, *, length: typing.SupportsFloat | typing.SupportsIndex, wrench: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(6)"], line_force: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], order: typing.SupportsInt | typing.SupportsIndex, steps: typing.SupportsInt | typing.SupportsIndex) -> tuple[typing.Annotated[list[float], "FixedSize(3)"], typing.Annotated[list[typing.Annotated[list[float], "FixedSize(3)"]], "FixedSize(3)"], typing.Annotated[list[float], "FixedSize(6)"]]:
    """
    Shoot a rod from the origin with a base wrench: end position, rotation and internal wrench.
    
    Parameters
    ----------
    section : Section
    length : float
        Rest length [m].
    wrench : sequence of 6 floats
        Internal force and moment at the base [N, N m].
    line_force : sequence of 3 floats
        Dead load per rest length [N/m].
    order, steps : int
        Which integrator of the list, and how many equal steps it takes.
    
    Raises
    ------
    ValueError
        The length is not positive, there is no step, or no integrator has that order.
    """
def status_names() -> list[str]:
    """
    Names of the outcomes of a solve, by number.
    """
def survey_rows(geometry: Geometry, members: Members, scene: Scene, pressures: numpy.typing.NDArray[numpy.float64], *, tolerance: typing.SupportsFloat | typing.SupportsIndex, section: str, valve: str, threads: typing.SupportsInt | typing.SupportsIndex, tick: collections.abc.Callable[[int], bool]) -> Atlas | None:
    """
    Solves rows of pressures (N, A) from nothing and fits an atlas to them, without the interpreter lock.
    
    None where an atlas does not serve: the limb is held, too few rows have an answer, rods need many pieces, or a row has
    another stable posture, which each row should then say itself. `tick` as for `sweep_rows`; none after a stop.
    """
def sweep_rows(geometry: Geometry, members: Members, scene: Scene, pressures: numpy.typing.NDArray[numpy.float64], *, tolerance: typing.SupportsFloat | typing.SupportsIndex, prefer_stable: bool, section: str, valve: str, ordered: bool, atlas: Atlas | None, threads: typing.SupportsInt | typing.SupportsIndex, start: Posture | None, start_plates: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] | None, tip: numpy.typing.NDArray[numpy.float64], plates: numpy.typing.NDArray[numpy.float64], status: numpy.typing.NDArray[numpy.int8], success: numpy.typing.NDArray[numpy.bool], stable: numpy.typing.NDArray[numpy.bool], unstable_modes: numpy.typing.NDArray[numpy.int64], clearance: numpy.typing.NDArray[numpy.float64], iterations: numpy.typing.NDArray[numpy.int64], residual: numpy.typing.NDArray[numpy.float64], message: dict[int, str], tick: collections.abc.Callable[[int], bool]) -> None:
    """
    Solves one posture a row of pressures (N, A) into the given arrays, without the interpreter lock.
    
    `status` has numbers of `status_names`, and keeps what it has (-1) for rows not come to; where a row did not converge,
    poses, stability and clearance stay as they were. `message` gets by row what is more than "converged". `tick(done)` is
    asked ten times a second by the calling thread; false, an exception or Ctrl-C stops the workers and keeps what is done.
    """
def thread_geometry(*, inner: typing.SupportsFloat | typing.SupportsIndex, outer: typing.SupportsFloat | typing.SupportsIndex, thread_diameter: typing.SupportsFloat | typing.SupportsIndex, pitch: typing.SupportsFloat | typing.SupportsIndex, angle: typing.SupportsFloat | typing.SupportsIndex | None = None) -> ThreadGeometry:
    """
    Thread wound in a helix at the inner radius of a layer.
    
    Parameters
    ----------
    inner, outer : float
        Radii of the layer [m].
    thread_diameter : float
        [m].
    pitch : float
        Axial distance between turns of one family [m].
    angle : float, optional
        From the circumferential direction [rad]. Default: that of the pitch, ``tan(angle) = pitch / (2 pi inner)``.
    
    Returns
    -------
    ThreadGeometry
    
    Raises
    ------
    ValueError
        A length is not positive, the turns overlap, or the angle is outside (0, pi/2).
    """
def tip_by_pressures(followed: Posture, members: Members, section: str, valve: str, pressures: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] | None) -> numpy.typing.NDArray[numpy.float64]:
    """
    Tip (dp, dtheta) by each pressure, (6, actuators), of a posture that was followed: by the linearisation that its solve ended with. At its own pressures where none are given; RuntimeError where it has none.
    """
def use_instruction_set(name: str) -> None:
    """
    Integrates with another one from now on; ValueError when the machine has it not. Answers agree to rounding.
    """
def yardstick(*, repetitions: typing.SupportsInt | typing.SupportsIndex = 9) -> tuple[float, float]:
    """
    Microseconds of one pass of a fixed loop (nine rods of eight Runge-Kutta steps, plain scalar code), the least of `repetitions` times 2000 passes, and its checksum, 0.159407.
    """
CHUNK_ROWS: int = 32
