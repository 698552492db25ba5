"""Solving many scenarios side by side."""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import json
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import CancelledError, ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue
from typing import Any

from ._json import given, named, text
from ._native import _aghf
from ._solution import Solution, from_summary
from ._solve import Guess, Integrator, Method, PlannedStarts, solve

Scenario = str | os.PathLike[str] | Mapping[str, Any]
Result = Solution | Exception
Request = tuple[str, str | None]
SUMMARY, REQUEST = "summary.json", "request.json"
OWN = {"scenario", "running_cost", "constraints", "on_iteration", "start", "threads"}


def solve_each(
    scenarios: Mapping[str, Scenario] | Iterable[Scenario],
    *,
    folder: str | os.PathLike[str] | None = None,
    threads: int | None = None,
    progress: bool | None = None,
    **options: Any,
) -> Iterator[tuple[str | int, Result]]:
    """Solves scenarios in parallel, and yields each with its id as soon as it is done.

    A scenario that is refused has its exception, such as an `InputError`. Ctrl-C ends all searches and raises.

    Parameters
    ----------
    scenarios : Mapping or iterable
        Scenarios as for `solve` by their ids, or in a list, where the id is the index.
    folder : str or os.PathLike, optional
        A folder in which each motion is written as soon as it is done, in a folder of its own: `ID/summary.json`. A
        scenario whose motion is there is not solved again; one that was refused is tried again. The text of scenarios
        and the options have to be the same, other files, such as those of robots, are not compared.
    threads : int, optional
        The number of scenarios that are solved at the same time, by default one per core.
    progress : bool, optional
        True for a bar on the standard error that counts the results, which needs tqdm; by default if tqdm is installed
        and the standard error is a terminal.
    **options
        The options of `solve` for each of them.

    Raises
    ------
    ValueError
        An id is no name of a folder or that of two scenarios, or the folder has the motion of another scenario or with
        other options.
    """
    unknown = options.keys() - (inspect.signature(solve).parameters.keys() - OWN)
    if unknown:
        raise TypeError(f"solve_each() got an unexpected keyword argument '{min(unknown)}'")
    each = scenarios.items() if isinstance(scenarios, Mapping) else enumerate(scenarios)
    requests = [(name, named(scenario)) for name, scenario in each]
    if progress is None:
        progress = sys.stderr.isatty() and importlib.util.find_spec("tqdm") is not None
    results = _resumed(requests, given(options), folder, threads)
    if not progress:
        return results
    tqdm = importlib.import_module("tqdm").tqdm
    return iter(tqdm(results, total=len(requests), unit="scenario"))


def solve_many(
    scenarios: Iterable[Scenario],
    *,
    threads: int | None = None,
    method: Method | None = None,
    degree: int | None = None,
    segments: int | None = None,
    degree_tolerance: float | None = None,
    tolerance: float | None = None,
    reserve: float | None = None,
    starts: int | None = None,
    seed: int | None = None,
    planned_starts: PlannedStarts | None = None,
    time_limit_s: float | None = None,
    k: float | None = None,
    s_max: float | None = None,
    guess: Guess | None = None,
    jacobian: str | None = None,
    integrator: Integrator | None = None,
    k_cons: float | None = None,
    c_cons: float | None = None,
) -> list[Result]:
    """Solves scenarios in parallel, one per core or on this number of threads.

    The results are in the order of the scenarios and do not depend on the number of threads. A scenario that is refused
    has its exception in the list, such as an `InputError`. Ctrl-C ends all searches with the best motions so far; each
    scenario whose solve had not begun then has a `concurrent.futures.CancelledError`.

    Parameters
    ----------
    scenarios : iterable
        Scenarios as for `solve`.
    threads : int, optional
        The number of scenarios that are solved at the same time, by default one per core.
    method, degree, ... : optional
        The options of `solve` for each of them.
    """
    options = given(locals(), "scenarios", "threads")
    requests = [(k, named(scenario)) for k, scenario in enumerate(scenarios)]
    stop = threading.Event()
    is_main = threading.current_thread() is threading.main_thread()
    before = signal.signal(signal.SIGINT, lambda *_: stop.set()) if is_main else None
    try:
        found = dict(_side_by_side(requests, options, threads, stop))
    finally:
        if is_main:
            # A handler that was not installed by Python cannot be set again.
            signal.signal(signal.SIGINT, before or signal.default_int_handler)
    return [found[k] for k, _ in requests]


def _resumed(
    requests: list[tuple[Any, Request]], options: str, folder: str | os.PathLike[str] | None, threads: int | None
) -> Iterator[tuple[Any, Result]]:
    """The motions that a folder has, then the others, which are written there."""
    if folder is None:
        yield from _side_by_side(requests, options, threads, threading.Event())
        return
    known = set()
    for name in (str(name) for name, _ in requests):
        if name in ("", ".", "..") or Path(name).name != name or "\0" in name:
            raise ValueError(f"scenarios: '{name}' is no name of a folder")
        if name in known:
            raise ValueError(f"scenarios: '{name}' is the id of two")
        known.add(name)
    left = []
    for name, request in requests:
        own = Path(folder) / str(name)
        if not (own / SUMMARY).exists():
            left.append((name, request))
            continue
        if not (own / REQUEST).exists():
            raise ValueError(f"folder: {own} has a motion of another origin")
        if json.loads((own / REQUEST).read_text("utf-8")) != _record(request, options):
            raise ValueError(f"folder: {own} has the motion of another scenario or with other options")
        yield name, from_summary((own / SUMMARY).read_text("utf-8"))

    def write(name: object, request: Request, solution: Solution) -> None:
        own = Path(folder) / str(name)
        own.mkdir(parents=True, exist_ok=True)
        _write(own / REQUEST, json.dumps(_record(request, options)))
        # The last one, so that its presence says that the motion is complete.
        _write(own / SUMMARY, solution._own.summary_json())

    yield from _side_by_side(left, options, threads, threading.Event(), write)


def _record(request: Request, options: str) -> dict[str, Any]:
    """The scenario, with the text of its file, and the options: a folder has to have the same."""
    name, content = request
    if content is None and Path(name).is_file():
        content = Path(name).read_text("utf-8")
    scenario = name if content is None else json.loads(content)
    return {"name": name, "scenario": scenario, "options": json.loads(options)}


def _write(path: Path, content: str) -> None:
    """Writes a file as a whole or not at all."""
    part = path.with_suffix(".part")
    part.write_text(content, "utf-8")
    os.replace(part, path)


def _side_by_side(
    requests: list[tuple[Any, Request]],
    options: str,
    threads: int | None,
    stop: threading.Event,
    write: Callable[[object, Request, Solution], None] = lambda *_: None,
) -> Iterator[tuple[Any, Result]]:
    """The results as they come. Once `stop` is set searches end with the motions that they have, and no more begin."""
    if threads is not None and threads < 1:
        raise ValueError(f"threads: it is {threads} and must be at least 1")
    keys = json.loads(options)
    if keys.get("method", "direct") == "direct":
        # The solves share the cores.
        options = text({**keys, "threads": 1})
    done: SimpleQueue[tuple[Any, Solution | BaseException]] = SimpleQueue()

    def work(name: object, request: Request) -> None:
        try:
            if stop.is_set():
                raise CancelledError(f"{request[0]}: Ctrl-C came before its solve began")
            solution = Solution(_aghf.solve(request, options, None, [], (None, stop.is_set), None))
            write(name, request, solution)
            done.put((name, solution))
        except BaseException as error:
            done.put((name, error))

    pool = ThreadPoolExecutor(threads or os.cpu_count())
    try:
        for name, request in requests:
            pool.submit(work, name, request)
        for _ in requests:
            name, result = done.get()
            if not isinstance(result, (Solution, Exception)):
                raise result
            yield name, result
    finally:
        stop.set()
        pool.shutdown(cancel_futures=True)
