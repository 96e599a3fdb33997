"""Order conditions of Runge–Kutta methods, from rooted trees.

A method has order p when ``b·Φ(τ) = 1/γ(τ)`` for each rooted tree τ of up to p nodes [1]_.

References
----------
.. [1] E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed.,
       Springer 1993, theorem II.2.13.
"""

from __future__ import annotations

from functools import cache
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

# A tree is the sorted tuple of the trees that hang from its root; () is a single node.
Tree: TypeAlias = tuple["Tree", ...]


@cache
def rooted_trees(nodes: int) -> tuple[Tree, ...]:
    """All rooted trees with a number of nodes: 1, 1, 2, 4, 9, 20, 48, 115 for 1 to 8 nodes."""
    return tuple(_forests(nodes - 1, nodes - 1))


def _forests(nodes: int, largest: int) -> list[Tree]:
    """Multisets of trees with `nodes` nodes together, none larger than `largest`."""
    if nodes == 0:
        return [()]
    found = set()
    for size in range(1, min(nodes, largest) + 1):
        for tree in rooted_trees(size):
            for rest in _forests(nodes - size, size):
                found.add(tuple(sorted((tree, *rest))))
    return sorted(found)


@cache
def size(tree: Tree) -> int:
    """Count the nodes of a tree."""
    return 1 + sum(size(branch) for branch in tree)


@cache
def density(tree: Tree) -> int:
    """Density γ(τ): the product of the sizes of all subtrees."""
    product = size(tree)
    for branch in tree:
        product *= density(branch)
    return product


def stage_weights(
    tree: Tree, A: NDArray[np.float64], known: dict[Tree, NDArray[np.float64]]
) -> NDArray[np.float64]:
    """Elementary weights Φ(τ) of the stages, shape (s,); `known` keeps those computed before."""
    if tree not in known:
        product = np.ones(len(A))
        for branch in tree:
            product = product * (A @ stage_weights(branch, A, known))
        known[tree] = product
    return known[tree]


def order_defect(A: NDArray[np.float64], b: NDArray[np.float64], order: int) -> float:
    """Largest violation ``|b·Φ(τ) - 1/γ(τ)|`` over all trees of up to `order` nodes."""
    known: dict[Tree, NDArray[np.float64]] = {}
    return max(
        abs(float(b @ stage_weights(tree, A, known)) - 1 / density(tree))
        for nodes in range(1, order + 1)
        for tree in rooted_trees(nodes)
    )
