"""Every parameter of the plant, declared once: name, default, unit, meaning, source, range."""

import math
from typing import ClassVar

from rodless_base.parameters import Parameter, ParameterError, ParameterSet, declare

PAPER = "Zhang et al. 2022"
JUDGEMENT = "judgement"

# An explicit inner step follows a rate of change (1/s) faithfully while step x rate stays below
# this; a combination of values beyond it is refused instead of integrated badly.
MAXIMUM_STEP_TIMES_RATE = 0.7


def _direction(
    side: str, static: float, coulomb: float, velocity: float, viscous: float
) -> list[Parameter]:
    source = f"{PAPER}, Table 2"
    prefix = f"friction.{side}"
    return [
        Parameter(
            f"{prefix}.static", static, "N", f"breakaway force F_s, {side} motion", source, 0.0, 1e4
        ),
        Parameter(
            f"{prefix}.coulomb", coulomb, "N", f"Coulomb force F_c, {side} motion", source, 0.0, 1e4
        ),
        Parameter(
            f"{prefix}.stribeck_velocity",
            velocity,
            "m/s",
            f"Stribeck velocity v_s, {side} motion",
            source,
            1e-4,
            1.0,
        ),
        Parameter(
            f"{prefix}.viscous",
            viscous,
            "N·s/m",
            f"viscous coefficient B, {side} motion",
            source,
            0.0,
            1e5,
        ),
    ]


DECLARATIONS = declare(
    Parameter(
        "supply.pressure",
        0.52e6 + 101325.0,
        "Pa",
        "supply pressure P_s, absolute",
        f"{PAPER}, 6.2 (gauge reading assumed)",
        5e4,
        1.2e6,
    ),
    Parameter(
        "supply.temperature",
        297.0,
        "K",
        "supply temperature T_s, which the air keeps everywhere",
        f"{PAPER}, 3.5",
        200.0,
        400.0,
    ),
    Parameter(
        "atmosphere.pressure",
        101325.0,
        "Pa",
        "ambient pressure P_e, absolute",
        "standard atmosphere",
        5e4,
        1.2e5,
    ),
    Parameter(
        "atmosphere.temperature",
        293.15,
        "K",
        "ambient temperature, at which free-air flow is stated",
        "ISO 8778 reference atmosphere",
        200.0,
        400.0,
    ),
    Parameter(
        "air.gas_constant",
        287.05,
        "J/(kg·K)",
        "specific gas constant R",
        f"{PAPER}, 3.2, corrected",
        100.0,
        5000.0,
    ),
    Parameter("air.isentropic_index", 1.4, "", "isentropic index κ", f"{PAPER}, 3.2", 1.05, 1.7),
    Parameter(
        "air.critical_ratio",
        0.528,
        "",
        "critical pressure ratio b; must belong to the isentropic index",
        f"{PAPER}, 3.2",
        0.4,
        0.65,
    ),
    Parameter("air.viscosity", 1.83e-5, "Pa·s", "dynamic viscosity μ", f"{PAPER}, 3.3", 1e-6, 1e-4),
    Parameter(
        "valve.assembly",
        "reconciled",
        "",
        "how the valve equations are put together: reconciled, or printed as in the paper",
        "docs/errata.md",
        choices=("reconciled", "printed"),
    ),
    Parameter(
        "valve.closed_voltage",
        5.08,
        "V",
        "command at which the valve is closed; also its fail-safe position",
        f"{PAPER}, 3.5",
        4.0,
        6.0,
    ),
    Parameter(
        "valve.curve_centre",
        5.2416,
        "V",
        "voltage of the smallest area on the measured curve, eq. (5)",
        f"{PAPER}, eq. (5)",
        4.0,
        6.5,
    ),
    Parameter(
        "valve.area_coefficients",
        (2.108, 0.2636, 0.1742, 2.012, 0.4851, 2.157, -0.0933, 1.331, 0.9104),
        "mm², rad/V, rad",
        "amplitude, frequency and phase of the three sines of eq. (5)",
        f"{PAPER}, eq. (5)",
        -100.0,
        100.0,
    ),
    Parameter(
        "valve.flow_coefficients",
        (1.132, -0.006917, -0.0339, 0.02509, -0.006486, 0.0004983),
        "1/V^k",
        "flow coefficient polynomial, constant term first",
        f"{PAPER}, eq. (25)",
        -10.0,
        10.0,
    ),
    Parameter("valve.spool_diameter", 6e-3, "m", "spool diameter d_s", f"{PAPER}, 3.2", 1e-3, 0.05),
    Parameter(
        "valve.sleeve_diameter",
        6.023e-3,
        "m",
        "sleeve diameter d_h; gives the gap of the printed assembly by eq. (3)",
        f"{PAPER}, 3.2",
        1e-3,
        0.05,
    ),
    Parameter(
        "valve.gap_length", 2e-3, "m", "initial gap length L_0", f"{PAPER}, 3.3", 1.2e-3, 0.05
    ),
    Parameter(
        "valve.gap_height",
        6e-6,
        "m",
        "effective gap height h_0 of the reconciled assembly",
        f"{JUDGEMENT}: maker's leakage bound and eq. (5) near closed",
        0.0,
        5e-5,
    ),
    Parameter(
        "valve.gap_fade_voltage",
        0.2,
        "V",
        "deflection at which the opening edge's gap flow has faded by e (Gaussian)",
        f"{JUDGEMENT}: force on a held piston monotone, 5.24 V creeps as in Fig. 13",
        0.01,
        5.0,
    ),
    Parameter(
        "valve.command_timeout",
        0.1,
        "s",
        "time without a command after which the node closes the valve",
        JUDGEMENT,
        1e-3,
        60.0,
    ),
    Parameter("cylinder.bore", 0.025, "m", "piston diameter", "SMC CY3R25", 5e-3, 0.1),
    Parameter("cylinder.stroke", 0.2, "m", "stroke", "SMC CY3R25-200", 0.01, 2.0),
    Parameter(
        "cylinder.moving_mass",
        1.0,
        "kg",
        "mass m of piston, carriage and bracket",
        f"{JUDGEMENT}: not in the paper",
        0.05,
        100.0,
    ),
    Parameter(
        "cylinder.dead_volume_a",
        15e-6,
        "m³",
        "volume V_a0 of chamber A, tube and fittings at position 0",
        f"{JUDGEMENT}: cavity 5, tube 7.5, fittings 1-2 cm³",
        2e-6,
        1e-2,
    ),
    Parameter(
        "cylinder.dead_volume_b",
        15e-6,
        "m³",
        "volume of chamber B, tube and fittings at full stroke",
        f"{JUDGEMENT}: as chamber A",
        2e-6,
        1e-2,
    ),
    Parameter(
        "cylinder.initial_position",
        0.0,
        "m",
        "position of the carriage at the start and after a reset",
        "chamber A's end",
        0.0,
        2.0,
    ),
    Parameter(
        "cylinder.locked",
        False,
        "",
        "hold the carriage where it is, as for the fixed-chamber experiment",
        f"{PAPER}, 6.1",
    ),
    Parameter(
        "end_stop.stiffness", 2e5, "N/m", "contact stiffness of the end caps", JUDGEMENT, 1e3, 1e7
    ),
    Parameter(
        "end_stop.damping", 300.0, "N·s/m", "contact damping of the end caps", JUDGEMENT, 0.0, 1e5
    ),
    Parameter(
        "friction.form",
        "stribeck",
        "",
        "stribeck: eq. (29) as printed; saturating: its viscous term bends above creep speed",
        f"{PAPER}, eq. (29)",
        choices=("stribeck", "saturating"),
    ),
    *_direction("forward", 29.0, 12.0, 1.3e-3, 4500.0),
    *_direction("reverse", 36.0, 12.5, 3.6e-3, 4800.0),
    Parameter(
        "friction.high_speed_viscous",
        80.0,
        "N·s/m",
        "viscous coefficient B_2 well above the saturation velocity (saturating form)",
        f"{JUDGEMENT}: maker's speed range 50-500 mm/s",
        0.0,
        1e5,
    ),
    Parameter(
        "friction.saturation_velocity",
        5e-3,
        "m/s",
        "speed v_k over which the viscous term bends (saturating form)",
        JUDGEMENT,
        1e-4,
        1.0,
    ),
    Parameter(
        "friction.capture_velocity",
        1e-5,
        "m/s",
        "speed α below which a force within F_s holds the carriage, eq. (28)",
        JUDGEMENT,
        0.0,
        1e-4,
    ),
    Parameter(
        "sensors.position_noise",
        0.0,
        "m",
        "noise of the position sensor, standard deviation",
        f"{JUDGEMENT}: 20 µm",
        0.0,
        1e-2,
    ),
    Parameter(
        "sensors.position_linearity",
        0.0,
        "",
        "largest nonlinearity of the position sensor, share of its range",
        f"{PAPER}, Table 1: 0.05 %",
        0.0,
        0.05,
    ),
    Parameter(
        "sensors.position_repeatability",
        0.0,
        "m",
        "largest offset of the position sensor in a run",
        f"{PAPER}, Table 1: 0.01 mm",
        0.0,
        1e-2,
    ),
    Parameter(
        "sensors.pressure_noise",
        0.0,
        "Pa",
        "noise of the pressure sensors, standard deviation",
        f"{JUDGEMENT}: 200 Pa",
        0.0,
        1e5,
    ),
    Parameter(
        "sensors.pressure_bias",
        0.0,
        "",
        "largest bias of a pressure sensor, share of its range",
        f"{PAPER}, Table 1: 0.5 %",
        0.0,
        0.1,
    ),
    Parameter(
        "sensors.pressure_lag",
        0.0,
        "s",
        "time constant of the pressure sensors",
        f"{JUDGEMENT}: 5 ms",
        0.0,
        1.0,
    ),
    Parameter(
        "sensors.flow_noise",
        0.0,
        "m³/s",
        "noise of the volume-flow meter, standard deviation",
        f"{JUDGEMENT}: 0.1 L/min",
        0.0,
        1e-3,
    ),
    Parameter(
        "sensors.flow_gain_error",
        0.0,
        "",
        "largest error of the volume-flow meter, share of the reading",
        f"{JUDGEMENT}: 1 %",
        0.0,
        0.1,
    ),
    Parameter(
        "sensors.converter_bits",
        0,
        "",
        "bits of the converter over ±10 V, 0 for no rounding",
        f"{PAPER}, section 2: 16",
        0.0,
        24.0,
    ),
    Parameter(
        "sensors.seed",
        1,
        "",
        "draws the fixed errors of the sensors and, from each reset on, their noise",
        "interface",
        0,
        2**31 - 1,
    ),
    Parameter(
        "time.mode",
        "realtime",
        "",
        "realtime: paced by the wall clock; lockstep: one period for each command",
        "interface",
        choices=("realtime", "lockstep"),
        fixed=True,
    ),
    Parameter(
        "time.period",
        1e-3,
        "s",
        "period of the published samples",
        "interface",
        1e-4,
        1.0,
        fixed=True,
    ),
    Parameter(
        "time.inner_step",
        20e-6,
        "s",
        "longest integration step; the step used divides the period",
        "interface",
        1e-7,
        1e-4,
        fixed=True,
    ),
    Parameter(
        "time.speed",
        1.0,
        "",
        "plant seconds per wall-clock second (realtime)",
        "interface",
        1e-3,
        10.0,
        fixed=True,
    ),
    Parameter(
        "time.duration",
        0.0,
        "s",
        "plant time at which the run ends and the plant holds; 0 for never",
        "interface",
        0.0,
        1e6,
        fixed=True,
    ),
    Parameter(
        "time.command_timeout",
        1.0,
        "s",
        "wall-clock time without a command after which lockstep says so",
        "interface",
        1e-2,
        1e3,
        fixed=True,
    ),
    Parameter(
        "time.recorders",
        0,
        "",
        "recorders to wait for: with any, the plant starts once each of its topics has that many "
        "subscribers, joint_states one more",
        "interface",
        0,
        100,
        fixed=True,
    ),
    Parameter(
        "time.publish_clock",
        True,
        "",
        "publish plant time on /clock; switch off in all but one of several rigs",
        "interface",
        fixed=True,
    ),
)


class RigParameters(ParameterSet):
    """The plant's parameters; see docs/parameters.md."""

    DECLARATIONS: ClassVar[dict[str, Parameter]] = DECLARATIONS
    NODE: ClassVar[str] = "plant"

    def check_together(self) -> None:
        """Refuse combinations that no rig has, or that the inner step cannot follow."""
        self._check_pressures()
        self._check_critical_ratio()
        self._check_valve()
        self._check_friction()
        self._check_position()
        self._check_period()
        self._check_step()

    def _check_pressures(self) -> None:
        supply, ambient = self.number("supply.pressure"), self.number("atmosphere.pressure")
        if supply < ambient:
            raise ParameterError(
                f"supply.pressure: {supply:g} Pa refused, it is absolute and must not be below "
                f"atmosphere.pressure ({ambient:g} Pa)"
            )

    def _check_critical_ratio(self) -> None:
        index = self.number("air.isentropic_index")
        ratio = self.number("air.critical_ratio")
        theory = (2.0 / (index + 1.0)) ** (index / (index - 1.0))
        if abs(ratio - theory) > 1e-3:
            raise ParameterError(
                f"air.critical_ratio: {ratio:g} refused, air.isentropic_index {index:g} "
                f"needs {theory:.4f} within 0.001 or the flow jumps where it chokes"
            )

    def _check_valve(self) -> None:
        spool, sleeve = self.number("valve.spool_diameter"), self.number("valve.sleeve_diameter")
        if sleeve < spool:
            raise ParameterError(
                f"valve.sleeve_diameter: {sleeve:g} m refused, smaller than "
                f"valve.spool_diameter ({spool:g} m)"
            )

    def _check_friction(self) -> None:
        for side in ("forward", "reverse"):
            static = self.number(f"friction.{side}.static")
            coulomb = self.number(f"friction.{side}.coulomb")
            if static < coulomb:
                raise ParameterError(
                    f"friction.{side}.static: {static:g} N refused, below "
                    f"friction.{side}.coulomb ({coulomb:g} N)"
                )

    def _check_position(self) -> None:
        position, stroke = self.number("cylinder.initial_position"), self.number("cylinder.stroke")
        if position > stroke:
            raise ParameterError(
                f"cylinder.initial_position: {position:g} m refused, beyond "
                f"cylinder.stroke ({stroke:g} m)"
            )

    def _check_period(self) -> None:
        period, step = self.number("time.period"), self.number("time.inner_step")
        if step > period:
            raise ParameterError(
                f"time.inner_step: {step:g} s refused, longer than time.period ({period:g} s)"
            )
        timeout = self.number("valve.command_timeout")
        if period > timeout:
            raise ParameterError(
                f"time.period: {period:g} s refused, longer than valve.command_timeout "
                f"({timeout:g} s): commands come once a period, the valve would close in between"
            )
        if abs(period * 1e9 - round(period * 1e9)) > 1e-6:
            raise ParameterError(
                f"time.period: {period!r} s refused, not a whole number of nanoseconds"
            )

    def _check_step(self) -> None:
        step = self.number("time.inner_step")
        for what, rate in self._rates().items():
            if rate * step > MAXIMUM_STEP_TIMES_RATE:
                raise ParameterError(
                    f"{what}: changes within {1e6 / rate:.3g} µs, too fast for time.inner_step "
                    f"{step:g} s; choose at most {MAXIMUM_STEP_TIMES_RATE / rate:.2g} s"
                )

    def _rates(self) -> dict[str, float]:
        """Fastest rates of change of the mechanics in 1/s, by the parameter to blame."""
        mass = self.number("cylinder.moving_mass")
        rates = {
            "end_stop.stiffness": math.sqrt(self.number("end_stop.stiffness") / mass),
            "end_stop.damping": self.number("end_stop.damping") / mass,
        }
        for side in ("forward", "reverse"):
            name = f"friction.{side}"
            drop = self.number(f"{name}.static") - self.number(f"{name}.coulomb")
            slope = math.sqrt(2.0 / math.e) * drop / self.number(f"{name}.stribeck_velocity")
            rates[f"{name}.viscous"] = self.number(f"{name}.viscous") / mass
            rates[f"{name}.stribeck_velocity"] = slope / mass
        return rates
