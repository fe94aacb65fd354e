"""Plots, drawn to files: PIAD_PICTURES names a folder to keep them in."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("agg")

import matplotlib.pyplot as plt
import numpy as np
import pytest
from shapes import CURVE, FITS, SURFACE

import piad
from piad.geometry.plots import _abscissas


@pytest.fixture(autouse=True)
def figures_are_closed_and_say_nothing() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)
        yield
    plt.close("all")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return Path(os.environ.get("PIAD_PICTURES", tmp_path))


def ink(ax: Any, path: Path) -> float:
    """The part of the image that is not white."""
    ax.figure.savefig(path)
    return float((plt.imread(path)[..., :3] < 1).any(axis=-1).mean())


@pytest.mark.parametrize("name", FITS)
def test_every_shape(client: piad.Client, folder: Path, name: str) -> None:
    ax = piad.plot(client.fit(**FITS[name]), data=FITS[name]["points"])
    points = np.asarray(FITS[name]["points"])
    assert ax.name == ("3d" if points.shape[-1] == 3 else "rectilinear")
    assert ink(ax, folder / f"{name}.png") > 0.02
    drawn = next(line for line in ax.get_lines() if line.get_label() == "data")
    drawn = drawn.get_data_3d() if ax.name == "3d" else drawn.get_data()
    assert np.array_equal(np.transpose(drawn), points.reshape(-1, points.shape[-1]))


def test_curves_are_drawn_where_they_are(client: piad.Client) -> None:
    result = client.fit(**FITS["plane"])
    _, ax = plt.subplots()
    assert piad.plot(result.curve, ax=ax, samples=33, color="green", linewidth=3) is ax
    net, line = ax.get_lines()
    parameters = np.linspace(*result.curve.domain, 33)
    assert np.array_equal(np.transpose(line.get_data()), result.curve.evaluate(parameters))
    assert np.array_equal(np.transpose(net.get_data()), result.curve.control_points)
    assert (line.get_color(), line.get_linewidth(), ax.get_aspect()) == ("green", 3, 1.0)
    (only,) = piad.plot(result.curve, net=False).get_lines()
    assert only.get_label() == "curve"


def test_values_are_drawn_over_their_parameters(client: piad.Client, folder: Path) -> None:
    values = np.sin(np.arange(9.0))[:, None]
    result = client.fit(values, parameters="uniform", tolerance=1e-9)
    data = np.column_stack([result.parameters[0], values])
    ax = piad.plot(result, data=data)
    assert ink(ax, folder / "values.png") > 0.02
    net, line, dots = ax.get_lines()
    assert np.array_equal(np.transpose(dots.get_data()), data)
    assert np.allclose(line.get_ydata()[[0, -1]], values[[0, -1], 0], atol=1e-9)
    # The control polygon of a line is the line.
    straight = piad.plot(piad.Curve(result.curve.basis, _abscissas(result.curve.basis)[:, None]))
    assert np.allclose(*straight.get_lines()[1].get_data(), rtol=1e-14)
    heights = client.fit(np.array(SURFACE)[..., 2:], parameters="uniform")
    assert ink(piad.plot(heights), folder / "heights.png") > 0.02


def test_surfaces_of_the_plane_are_lines(client: piad.Client, folder: Path) -> None:
    plane = client.fit(np.array(SURFACE)[..., :2])
    assert ink(piad.plot(plane, data=np.array(SURFACE)[..., :2]), folder / "plane_surface.png") > 0.02


def test_derivatives_are_drawn(client: piad.Client, folder: Path) -> None:
    curve = client.fit(**FITS["plane"]).curve
    assert ink(piad.plot(curve.derivative(), color="purple"), folder / "hodograph.png") > 0.02


def test_errors_fall(client: piad.Client, folder: Path) -> None:
    job = client.create(CURVE, tolerance=1e-6)
    iterations = list(job.iterations(view="errors"))
    ax = piad.plot(iterations, tolerance=1e-6)
    assert ink(ax, folder / "errors.png") > 0.01
    largest, rms, limit = ax.get_lines()
    assert largest.get_ydata().tolist() == [it.error.max for it in iterations]
    assert rms.get_xdata().tolist() == [it.number for it in iterations]
    assert (ax.get_yscale(), limit.get_ydata()[0]) == ("log", 1e-6)
    # Iterators are accepted, too.
    assert len(piad.plot(job.iterations(every=5)).get_lines()) == 2


def test_errors_that_have_no_place(folder: Path) -> None:
    def level(number: int, largest: Any) -> piad.Iteration:
        return piad.Iteration(number, piad.Distances(largest, largest, largest, 0), 1)

    ax = piad.plot([level(0, None), level(1, 0.5), level(2, 0.0)])
    ax.figure.savefig(folder / "partly.png")
    assert np.isnan(ax.get_lines()[0].get_ydata()).tolist() == [True, False, True]
    piad.plot([level(0, 0.0)]).figure.savefig(folder / "exact.png")
    with pytest.raises(ValueError, match="no iterations"):
        piad.plot([])


def test_what_cannot_be_drawn(client: piad.Client, monkeypatch: pytest.MonkeyPatch) -> None:
    job = client.create(CURVE)
    with pytest.raises(ValueError, match='projection="3d"'):
        piad.plot(job.result(), ax=plt.subplots()[1])
    with pytest.raises(ValueError, match="another view"):
        piad.plot(next(iter(job.iterations(view="errors"))))
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", None)
    with pytest.raises(piad.MissingPackage, match=r"pip install piad\[plot\]"):
        piad.plot(job.result())
