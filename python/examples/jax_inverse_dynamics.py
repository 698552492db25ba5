"""Inverse dynamics in JAX: a callback whose derivatives are ours, not those of JAX.

    pip install "jax[cpu]"
    python python/examples/jax_inverse_dynamics.py
"""

import sys

import jax
import jax.numpy as jnp
import numpy as np

import aghf

jax.config.update("jax_enable_x64", True)


def inverse_dynamics(model: aghf.Model):
    """A function of q, v and a that JAX can compile, map over batches and differentiate forwards."""

    def shaped(x, *trailing):
        return jax.ShapeDtypeStruct((*x.shape, *trailing), x.dtype)

    def flat(function, count):
        """Over any leading dimensions, as numpy."""

        def call(q, v, a):
            lead = np.shape(q)[:-1]
            found = function(model, *(np.asarray(x).reshape(-1, model.dof) for x in (q, v, a)))
            found = found if count > 1 else (found,)
            found = tuple(x.reshape(*lead, *x.shape[1:]) for x in found[:count])
            return found if count > 1 else found[0]

        return call

    @jax.custom_jvp
    def rnea(q, v, a):
        return jax.pure_callback(flat(aghf.rnea, 1), shaped(q), q, v, a, vmap_method="broadcast_all")

    @rnea.defjvp
    def rnea_jvp(primals, tangents):
        q = primals[0]
        n = model.dof
        shapes = (shaped(q), shaped(q, n), shaped(q, n), shaped(q, n))
        call = flat(aghf.rnea_derivatives, 4)
        tau, *blocks = jax.pure_callback(call, shapes, *primals, vmap_method="broadcast_all")
        products = (jnp.einsum("...ij,...j->...i", block, by) for block, by in zip(blocks, tangents, strict=True))
        return tau, sum(products)

    return rnea


def main() -> float:
    model = aghf.Model.builtin("kinova_gen3")
    rnea = inverse_dynamics(model)
    q, v, a = jnp.asarray(np.random.default_rng(0).normal(size=(3, 50, model.dof)))

    def effort(q, v, a):
        return jnp.sum(rnea(q, v, a) ** 2)

    gradient = jax.jit(jax.vmap(jax.grad(effort)))(q, v, a)
    tau = aghf.rnea(model, np.asarray(q), np.asarray(v), np.asarray(a))
    exact = 2.0 * aghf.rnea_vjp(model, np.asarray(q), np.asarray(v), np.asarray(a), tau).q
    difference = float(np.abs(gradient - exact).max() / np.abs(exact).max())
    print(f"gradient of the squared torques by JAX and by the library: relative difference {difference:.1e}")
    return difference


if __name__ == "__main__":
    sys.exit(int(main() > 1e-10))
