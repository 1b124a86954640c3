"""Every parameter of the controller, declared once: name, default, unit, meaning, source, range."""

from typing import ClassVar

from rodless_base.parameters import Parameter, ParameterError, ParameterSet, declare

TUNED = "tuned on the simulated rig"

DECLARATIONS = declare(
    Parameter("controller.kp", 800.0, "V/m", "proportional gain", TUNED, 0.0, 1e5),
    Parameter("controller.ki", 55.0, "V/(m·s)", "integral gain", TUNED, 0.0, 1e5),
    Parameter(
        "controller.kd",
        60.0,
        "V·s/m",
        "derivative gain, on the filtered measurement",
        TUNED,
        0.0,
        1e4,
    ),
    Parameter(
        "controller.filter_bandwidth",
        50.0,
        "rad/s",
        "bandwidth of the measurement filter of the derivative",
        TUNED,
        1.0,
        1e5,
    ),
    Parameter(
        "controller.feedforward",
        75.0,
        "V·s/m",
        "voltage per reference velocity, added inside the limits",
        TUNED,
        0.0,
        1e3,
    ),
    Parameter(
        "controller.integral_zone",
        2.5e-3,
        "m",
        "error beyond which the integrator holds",
        TUNED,
        0.0,
        10.0,
    ),
    Parameter(
        "controller.error_dead_band",
        6e-5,
        "m",
        "error within which the integrator holds, so that a stuck carriage is left in peace",
        TUNED,
        0.0,
        0.1,
    ),
    Parameter(
        "controller.anti_windup",
        "conditional_integration",
        "",
        "what the integrator does at a limit: hold, be driven back, or nothing",
        "Åström and Hägglund, PID Controllers, 1995, section 3.5",
        choices=("conditional_integration", "back_calculation", "none"),
    ),
    Parameter(
        "controller.tracking_time",
        0.1,
        "s",
        "time constant of back-calculation, and of what makes a change of gains bumpless",
        "Åström and Hägglund, PID Controllers, 1995, section 3.5",
        1e-3,
        100.0,
    ),
    Parameter(
        "controller.dead_zone_voltage",
        0.6,
        "V",
        "voltage added in the direction of the command to cross the valve's flat centre",
        TUNED,
        0.0,
        2.0,
    ),
    Parameter(
        "controller.dead_zone_width",
        0.3,
        "V",
        "command at which three quarters of the dead-zone voltage is added",
        TUNED,
        1e-4,
        5.0,
    ),
    Parameter(
        "controller.neutral_voltage",
        5.08,
        "V",
        "valve command for no flow; also the fail-safe command",
        "Zhang et al. 2022, 3.5",
        0.0,
        10.0,
    ),
    Parameter(
        "controller.minimum_voltage",
        0.0,
        "V",
        "lower limit of the command",
        "Festo MPYE",
        0.0,
        10.0,
    ),
    Parameter(
        "controller.maximum_voltage",
        10.0,
        "V",
        "upper limit of the command",
        "Festo MPYE",
        0.0,
        10.0,
    ),
    Parameter(
        "controller.position_timeout",
        0.1,
        "s",
        "time without a position after which the valve is commanded to neutral; 0 for never",
        "judgement",
        0.0,
        60.0,
    ),
    Parameter(
        "controller.recorders",
        0,
        "",
        "recorders to wait for: positions are listened to once valve/voltage has this many "
        "subscribers and one more, and none of them loses a command",
        "interface",
        0,
        100,
        fixed=True,
    ),
    Parameter(
        "controller.joint",
        "carriage",
        "",
        "name of the joint to control in joint_states",
        "interface",
    ),
    Parameter(
        "reference.type",
        "setpoint",
        "",
        "setpoint: jump to each message; ramp, move: go there at a velocity, jerk-limited; "
        "step, sine: from these parameters alone",
        "interface",
        choices=("setpoint", "ramp", "move", "step", "sine"),
    ),
    Parameter(
        "reference.start",
        0.0,
        "m",
        "position before the step",
        "Zhang et al. 2022, 6.2",
        -1.0,
        10.0,
    ),
    Parameter(
        "reference.target",
        0.058,
        "m",
        "position after the step",
        "Zhang et al. 2022, 6.2",
        -1.0,
        10.0,
    ),
    Parameter(
        "reference.at", 0.5, "s", "plant time of the step or sine's start", "interface", 0.0, 1e6
    ),
    Parameter("reference.centre", 0.1, "m", "centre of the sine", "mid-stroke", -1.0, 10.0),
    Parameter("reference.amplitude", 0.02, "m", "amplitude of the sine", "judgement", 0.0, 10.0),
    Parameter(
        "reference.frequency",
        0.381,
        "Hz",
        "frequency of the sine",
        "Zhang et al. 2022, 6.3",
        0.0,
        100.0,
    ),
    Parameter(
        "reference.velocity", 0.05, "m/s", "velocity of ramps and moves", "judgement", 1e-6, 10.0
    ),
    Parameter(
        "reference.acceleration", 0.5, "m/s²", "acceleration limit of moves", "judgement", 1e-6, 1e3
    ),
    Parameter("reference.jerk", 10.0, "m/s³", "jerk limit of moves", "judgement", 1e-6, 1e6),
)


class PidParameters(ParameterSet):
    """The controller's parameters; see docs/parameters.md."""

    DECLARATIONS: ClassVar[dict[str, Parameter]] = DECLARATIONS
    NODE: ClassVar[str] = "controller"

    def check_together(self) -> None:
        """Refuse limits that leave the neutral voltage outside."""
        low = self.number("controller.minimum_voltage")
        high = self.number("controller.maximum_voltage")
        neutral = self.number("controller.neutral_voltage")
        if not low < neutral < high:
            raise ParameterError(
                f"controller.neutral_voltage: {neutral:g} V refused, must lie between "
                f"controller.minimum_voltage ({low:g} V) and maximum_voltage ({high:g} V)"
            )
