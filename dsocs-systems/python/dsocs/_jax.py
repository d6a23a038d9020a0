"""Motions as functions of jax, which differentiates them by the exact gradients of their steps."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Callable, Mapping, Sequence

import numpy as np

from . import _inputs
from ._errors import Error, SetupError

if TYPE_CHECKING:
    from ._system import System


def function(
    system: System, until: float, variables: Sequence[str], fixed: Mapping[str, Any], values: Mapping[str, Any]
) -> Callable[..., Any]:
    """A function of position, velocity and parameters at the start, which returns position and velocity at the end."""
    try:
        import jax
        import jax.numpy as jnp
    except ImportError:
        raise Error("jax is not installed (pip install jax); path(…).gradient(…) gives the same derivatives without it") from None
    if not jax.config.jax_enable_x64:
        raise SetupError('jax computes in single precision: jax.config.update("jax_enable_x64", True), before anything else')
    names, known = list(variables), [of.name for of in system._parameters]
    for name in names:
        if name not in known:
            raise _inputs.unknown("parameter", name, known)
    n = len(system._names)
    vector = jax.ShapeDtypeStruct((n,), np.float64)
    weights = jax.ShapeDtypeStruct((len(names),), np.float64)

    def path(q: Any, v: Any, p: Any) -> Any:
        given = dict(zip(names, np.asarray(p).tolist()))
        return system.path(until, q=np.asarray(q), v=np.asarray(v), parameters={**values, **given}, **fixed)

    def end_of(q: Any, v: Any, p: Any) -> tuple[Any, Any]:
        last = path(q, v, p).end
        return last.q, last.v

    def pulled_back(q: Any, v: Any, p: Any, by_q: Any, by_v: Any) -> tuple[Any, Any, Any]:
        by_q, by_v = np.asarray(by_q), np.asarray(by_v)
        found = path(q, v, p).gradient(lambda last: np.sum(last.q * by_q) + np.sum(last.v * by_v))
        return found.q, found.v, np.array([found.parameters[name] for name in names])

    def run(q: Any, v: Any, p: Any) -> Any:
        return jax.pure_callback(end_of, (vector, vector), q, v, p, vmap_method="sequential")

    end = jax.custom_vjp(run)

    def forward(q: Any, v: Any, p: Any) -> Any:
        return end(q, v, p), (q, v, p)

    def backward(kept: Any, by: Any) -> Any:
        return jax.pure_callback(pulled_back, (vector, vector, weights), *kept, *by, vmap_method="sequential")

    end.defvjp(forward, backward)

    def motion(q: Any, v: Any, p: Any = ()) -> Any:
        q, v, p = (jnp.asarray(x, dtype=jnp.float64) for x in (q, v, p))
        for what, x, shape in (("q", q, (n,)), ("v", v, (n,)), ("p", p, (len(names),))):
            if x.shape != shape:
                raise SetupError(f"{what} has the shape {x.shape}; expected {shape}")
        return end(q, v, p)

    return motion
