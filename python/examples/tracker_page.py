"""The record of a closed loop, its figures, and a page that shows them."""

import html
import io
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

EDGES_MS = [0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0, np.inf]
HEAD = """<!doctype html><html lang="en"><meta charset="utf-8"><title>Closed loop</title>
<style>body { font: 16px sans-serif; max-width: 70rem; margin: 2rem auto } svg { width: 100%; height: auto }</style>
"""


@dataclass
class Loop:
    """The record of a closed loop, one entry per step unless a comment says otherwise."""

    latency: list[float] = field(default_factory=list)  # s
    processor: list[float] = field(default_factory=list)  # s
    error: list[float] = field(default_factory=list)  # of the tool from the target, m
    deviation: list[float] = field(default_factory=list)  # of a joint from the plan, rad
    safety: list[str] = field(default_factory=list)
    # The largest share of its limit that a joint uses.
    position: list[float] = field(default_factory=list)
    velocity: list[float] = field(default_factory=list)
    torque: list[float] = field(default_factory=list)
    clearance: list[tuple[float, float]] = field(default_factory=list)  # at some times: s, m
    iterations: int = 0
    plans: int = 0

    @property
    def least_clearance(self) -> float:
        return min(distance for _, distance in self.clearance)

    @property
    def is_within_limits(self) -> bool:
        return max(self.position + self.velocity) <= 1.0

    def figures(self) -> list[str]:
        """The figures in words."""
        steps, mean = len(self.error), float(np.mean(self.latency))
        lines = [f"{steps} steps at {1 / mean:.0f} Hz, {self.iterations} iterations, {self.plans} plans"]
        for name, times in (("latency", self.latency), ("processor time", self.processor)):
            quantiles = " / ".join(f"{1e3 * np.quantile(times, share):.2f}" for share in (0.5, 0.99, 0.999))
            lines.append(f"{name}, ms: {quantiles} (median / 99 % / 99.9 %)")
        counts, _ = np.histogram(1e3 * np.array(self.latency), EDGES_MS)
        below = (f"below {high:g} ms: {count}" for high, count in zip(EDGES_MS[1:], counts, strict=True))
        kinds = {kind: self.safety.count(kind) for kind in sorted(set(self.safety))}
        shares = {name: getattr(self, name) for name in ("position", "velocity", "torque")}
        return [
            *lines,
            ", ".join(below),
            f"tool from target, m: {np.mean(self.error):.3f} in the mean, {max(self.error):.3f} at most",
            f"joints from plan, rad: {np.mean(self.deviation):.4f} in the mean, {max(self.deviation):.4f} at most",
            f"least clearance in MuJoCo, m: {self.least_clearance:.4f}; steps by safety: {kinds}",
            "share of limits, at most: " + ", ".join(f"{name} {max(by):.3f}" for name, by in shares.items()),
        ]

    def picture(self, period: float) -> str:
        """Latencies, errors, clearances and shares of limits, as SVG."""
        figure = Figure(figsize=(11, 7), layout="constrained")
        (latency, error), (clearance, shares) = figure.subplots(2, 2)
        latency.hist(1e3 * np.array(self.latency), bins=100, log=True)
        latency.set(xlabel="latency, ms", ylabel="steps")
        times = period * np.arange(len(self.error))
        error.plot(times, self.error)
        error.set(xlabel="time, s", ylabel="tool from target, m")
        clearance.plot(*np.transpose(self.clearance))
        clearance.set(xlabel="time, s", ylabel="clearance in MuJoCo, m", ylim=(0.0, None))
        for name in ("position", "velocity", "torque"):
            shares.plot(times, getattr(self, name), label=name)
        shares.set(xlabel="time, s", ylabel="share of the limit", ylim=(0.0, 1.05))
        shares.legend()
        text = io.StringIO()
        figure.savefig(text, format="svg", metadata={"Date": None})
        return text.getvalue()[text.getvalue().index("<svg") :]


def write(path: Path, title: str, loops: dict[str, Loop], period: float) -> None:
    """Writes a page that needs no other file."""
    parts = [HEAD, f"<h1>{html.escape(title)}</h1>"]
    for name, loop in loops.items():
        lines = "".join(f"<li>{html.escape(line)}" for line in loop.figures())
        parts.append(f"<h2>{html.escape(name)}</h2><ul>{lines}</ul>{loop.picture(period)}")
    path.write_text("\n".join(parts), encoding="utf-8")
