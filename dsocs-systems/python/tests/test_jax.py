"""Motions as functions of jax."""

from __future__ import annotations

from typing import Any, Iterator

import numpy as np
import pytest

import dsocs


@pytest.fixture(scope="module")
def jax() -> Iterator[Any]:
    module = pytest.importorskip("jax")
    before = module.config.jax_enable_x64
    module.config.update("jax_enable_x64", True)
    yield module
    module.config.update("jax_enable_x64", before)


def test_a_gradient_in_jax_is_that_of_the_path(jax: Any, swing: dsocs.System) -> None:
    end = swing.in_jax(1.0, ["length", "friction"], h=0.01)

    def cost(q: Any, v: Any, p: Any) -> Any:
        last_q, last_v = end(q, v, p)
        return last_q[0] ** 2 + jax.numpy.sin(last_v[0])

    given = (np.array([1.0]), np.array([0.5]), np.array([1.2, 0.1]))
    value, found = jax.jit(jax.value_and_grad(cost, argnums=(0, 1, 2)))(*given)
    exact = swing.path(1.0, h=0.01, q=given[0], v=given[1], length=1.2).gradient(lambda last: last["theta"] ** 2 + np.sin(last["v_theta"]))
    assert float(value) == pytest.approx(exact.cost, rel=1e-14)
    np.testing.assert_allclose(found[0], exact.q, rtol=1e-12)
    np.testing.assert_allclose(found[1], exact.v, rtol=1e-12)
    np.testing.assert_allclose(found[2], [exact.parameters["length"], exact.parameters["friction"]], rtol=1e-12)


def test_jax_maps_it_over_many_starts(jax: Any, swing: dsocs.System) -> None:
    end = swing.in_jax(1.0, h=0.01)
    starts = np.linspace(0.5, 2.0, 4)[:, None]
    q, v = jax.vmap(end)(starts, np.zeros((4, 1)))
    np.testing.assert_allclose(q, [swing.path(1.0, h=0.01, q=row, v=[0.0]).end.q for row in starts])
    assert v.shape == (4, 1)


def test_what_jax_cannot_be_given_is_refused(jax: Any, swing: dsocs.System) -> None:
    with pytest.raises(dsocs.SetupError, match="no parameter `lenght`"):
        swing.in_jax(1.0, ["lenght"])
    with pytest.raises(dsocs.SetupError, match=r"p has the shape \(0,\); expected \(1,\)"):
        swing.in_jax(1.0, ["length"])([1.0], [0.0])
    jax.config.update("jax_enable_x64", False)
    try:
        with pytest.raises(dsocs.SetupError, match="single precision"):
            swing.in_jax(1.0)
    finally:
        jax.config.update("jax_enable_x64", True)
