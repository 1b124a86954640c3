"""What the plant says once it is ready: how it runs, and what it waits for."""

from rodless_sim.parameters import RigParameters


def ready_line(values: RigParameters, samples: str, commands: str) -> str:
    """Return the line for a plant on the topics ``samples`` and ``commands`` (full names)."""
    gauge = values.number("supply.pressure") - values.number("atmosphere.pressure")
    return (
        f"ready: {_mode(values)}, supply {gauge * 1e-6:.3f} MPa gauge; "
        f"waiting for {_wanted(values, samples)} {commands}"
    )


def _mode(values: RigParameters) -> str:
    rate, speed = 1.0 / values.number("time.period"), values.number("time.speed")
    if values.text("time.mode") == "lockstep":
        return f"lockstep, {rate:g} samples per second of plant time"
    return f"realtime, {rate:g} Hz" + (f" at speed {speed:g}" if speed != 1.0 else "")


def _wanted(values: RigParameters, samples: str) -> str:
    recorders = int(values.number("time.recorders"))
    lockstep = values.text("time.mode") == "lockstep"
    commands = "one publisher on" if lockstep else "commands on"
    if not lockstep and not recorders:
        return commands
    subscribers = f"{recorders + 1} subscribers" if recorders else "a subscriber"
    return f"{subscribers} to {samples} and {commands}"
