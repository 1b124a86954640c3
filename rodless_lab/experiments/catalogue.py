"""Every experiment by name: what it repeats, and how to run it."""

from collections.abc import Callable
from dataclasses import dataclass

from rodless_lab.experiments import sine
from rodless_lab.experiments.errata import run_errata
from rodless_lab.experiments.fixed_chamber import run_fixed_chamber
from rodless_lab.experiments.flow_coefficient import run_flow_coefficient
from rodless_lab.experiments.friction import run_friction
from rodless_lab.experiments.result import Result
from rodless_lab.experiments.runner import IN_PROCESS, Bench
from rodless_lab.experiments.step import run_step
from rodless_lab.experiments.valve_area import run_valve_area


@dataclass(frozen=True)
class Options:
    """What a user may choose; lengths in m. Each experiment takes what concerns it."""

    presets: tuple[str, ...] = ("paper", "calibrated")
    amplitude: float = sine.AMPLITUDE
    centre: float = sine.CENTRE
    position: float = 0.0
    seed: int = 1
    bench: Bench = IN_PROCESS


@dataclass(frozen=True)
class Experiment:
    """One experiment of the paper; ``moves``: it drives a rig, so the nodes can do it."""

    name: str
    title: str
    source: str
    summary: str
    run: Callable[[Options], Result]
    moves: bool = False


EXPERIMENTS = {
    experiment.name: experiment
    for experiment in (
        Experiment(
            "valve-area",
            "Effective area of the valve",
            "section 3.2, Figs. 6 and 7, eqs. (4) and (5)",
            "The supply is held at 0.4 MPa and the voltage swept from 0 to 10 V and back, three "
            "times, while a port blows to atmosphere through a flow meter. Eq. (4) makes an area "
            "of the flow; three sines are fitted to its mean.",
            lambda options: run_valve_area(options.seed),
        ),
        Experiment(
            "flow-coefficient",
            "Flow coefficient of the valve",
            "section 3.5, Figs. 10 and 11, eqs. (23) and (25)",
            "At 0.5 MPa and 297 K the mass flow through the opening port, divided by that of an "
            "ideal nozzle of the measured area, is the flow coefficient; a polynomial of fifth "
            "degree is fitted to it.",
            lambda options: run_flow_coefficient(options.seed),
        ),
        Experiment(
            "friction",
            "Friction of the cylinder",
            "section 5.1, Figs. 12 to 16, Table 2, eqs. (28) to (30)",
            "At 0.5 MPa the carriage runs at constant voltages, forward and in reverse. Where it "
            "moves uniformly the pressure difference is the friction, eq. (30); eq. (29) is fitted "
            "to speed and friction by robust least squares.",
            lambda options: run_friction(options.seed, options.bench),
            moves=True,
        ),
        Experiment(
            "fixed-chamber",
            "Filling and venting fixed chambers",
            "section 6.1, Figs. 17 and 18",
            "The piston is held. The spool goes to its end, then to 5.08 V until the pressures "
            "settle, then to 4.4 V: chamber A vents and chamber B fills. Repeated at 0.4, 0.5 and "
            "0.6 MPa.",
            lambda options: run_fixed_chamber(options.position, bench=options.bench),
            moves=True,
        ),
        Experiment(
            "step",
            "Step of 58 mm",
            "section 6.2, Fig. 19",
            "At 0.52 MPa the PID controller moves the carriage from 0 to 58 mm.",
            lambda options: run_step(options.presets, options.bench),
            moves=True,
        ),
        Experiment(
            "sine",
            "Sine of 0.381 Hz",
            "section 6.3, Fig. 20",
            "At 0.52 MPa the PID controller follows a sine of 0.381 Hz about mid-stroke.",
            lambda options: sine.run_sine(
                options.presets, options.amplitude, options.centre, options.bench
            ),
            moves=True,
        ),
        Experiment(
            "errata",
            "What the paper's equations do as printed",
            "all of it",
            "For each fault of the paper that is more than a word, the number or picture that "
            "shows it, beside that of the form used.",
            lambda _: run_errata(),
        ),
    )
}
