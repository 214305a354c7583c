"""Elimination orders with little fill: approximate minimum degree on a quotient graph of weighted nodes.

Source: Amestoy, Davis, Duff, "An approximate minimum degree ordering algorithm", SIAM J. Matrix Anal. Appl. 17 (1996).
An eliminated node becomes an element, the set of nodes it ties together; a node is known by the nodes and elements
next to it, and nodes that are next to the same ones are merged.
"""

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def minimum_degree(start, neighbours, weight):
    """Order of elimination of the nodes of a graph; node i has neighbours[start[i] : start[i + 1]] and a weight."""
    n, total = len(weight), 0
    for i in range(n):
        total += weight[i]
    near_nodes, near_elements = neighbours.copy(), np.empty_like(neighbours)
    node_count, element_count = np.empty(n, np.int64), np.zeros(n, np.int64)
    size, alive = weight.copy(), np.zeros(n, np.bool_)
    next_member, last_member = np.full(n, -1), np.arange(n)
    pool, pool_end = np.empty(4 * len(neighbours) + n, np.int64), 0
    begin, count, element_weight = np.zeros(n, np.int64), np.zeros(n, np.int64), np.zeros(n, np.int64)
    mark, mark_element, outside = np.full(n, -1), np.full(n, -1), np.zeros(n, np.int64)
    degree, chain_head, chain_next = np.zeros(n, np.int64), np.full(n, -1), np.full(n, -1)
    head, following, previous = np.full(total + 1, -1), np.full(n, -1), np.full(n, -1)
    for i in range(n):
        node_count[i] = start[i + 1] - start[i]
        for k in range(start[i], start[i + 1]):
            degree[i] += weight[neighbours[k]]
        _insert(i, degree[i], head, following, previous)
    order, ordered, eliminated, lowest, stamp = np.empty(n, np.int64), 0, 0, 0, 0
    while eliminated < total:
        while head[lowest] < 0:
            lowest += 1
        p = head[lowest]
        _remove(p, degree[p], head, following, previous)
        member = p
        while member >= 0:
            order[ordered] = member
            ordered += 1
            member = next_member[member]
        eliminated += size[p]
        size[p] = 0
        bound = node_count[p]
        for k in range(start[p], start[p] + element_count[p]):
            bound += count[near_elements[k]]
        if pool_end + bound > len(pool):
            pool = _grown(pool, pool_end, 2 * len(pool) + bound)
        stamp += 1
        begin[p] = pool_end
        pool_end = _tie(
            p, start, near_nodes, node_count, near_elements, element_count, size, alive, begin, count, mark, stamp,
            pool, pool_end,
        )  # fmt: skip
        tied = pool[begin[p] : pool_end]
        tied_weight = _count_outside(
            tied, start, near_elements, element_count, size, alive, element_weight, outside, mark_element, stamp
        )
        alive[p] = True
        for v in tied:
            _remove(v, degree[v], head, following, previous)
            beyond = _forget(
                v, p, start, near_nodes, node_count, near_elements, element_count, size, alive, outside, mark, stamp
            )
            others = tied_weight - size[v]
            degree[v] = min(degree[v] + others, others + beyond, total - eliminated - size[v])
        _merge_alike(
            tied, start, near_nodes, node_count, near_elements, element_count, size, degree, next_member, last_member,
            chain_head, chain_next,
        )  # fmt: skip
        kept = 0
        for v in tied:
            if size[v] > 0:
                tied[kept] = v
                kept += 1
                _insert(v, degree[v], head, following, previous)
                lowest = min(lowest, degree[v])
        count[p], element_weight[p] = kept, tied_weight
        pool_end = begin[p] + kept
    return order


@njit(cache=True, nogil=True)
def _tie(
    p, start, near_nodes, node_count, near_elements, element_count, size, alive, begin, count, mark, stamp, pool, end
):  # fmt: skip
    """Append the nodes that eliminating p ties together to the pool, mark them, and absorb the elements of p."""
    for k in range(start[p], start[p] + node_count[p]):
        v = near_nodes[k]
        if size[v] > 0 and mark[v] != stamp:
            mark[v] = stamp
            pool[end] = v
            end += 1
    for k in range(start[p], start[p] + element_count[p]):
        e = near_elements[k]
        if not alive[e]:
            continue
        alive[e] = False
        for m in range(begin[e], begin[e] + count[e]):
            v = pool[m]
            if size[v] > 0 and mark[v] != stamp:
                mark[v] = stamp
                pool[end] = v
                end += 1
    return end


@njit(cache=True, nogil=True)
def _count_outside(
    tied, start, near_elements, element_count, size, alive, element_weight, outside, mark_element, stamp
):  # fmt: skip
    """Weight of each element next to tied nodes that lies outside them; returns the weight of the tied nodes."""
    tied_weight = 0
    for v in tied:
        tied_weight += size[v]
        for k in range(start[v], start[v] + element_count[v]):
            e = near_elements[k]
            if not alive[e]:
                continue
            if mark_element[e] != stamp:
                mark_element[e], outside[e] = stamp, element_weight[e]
            outside[e] -= size[v]
    return tied_weight


@njit(cache=True, nogil=True)
def _forget(
    v, p, start, near_nodes, node_count, near_elements, element_count, size, alive, outside, mark, stamp
):  # fmt: skip
    """Drop from v what element p says already, and give it p; returns the weight next to v outside p."""
    beyond, kept = 0, 0
    for k in range(start[v], start[v] + element_count[v]):
        e = near_elements[k]
        if alive[e] and outside[e] == 0:
            alive[e] = False
        if alive[e]:
            near_elements[start[v] + kept] = e
            kept += 1
            beyond += outside[e]
    near_elements[start[v] + kept] = p
    element_count[v] = kept + 1
    kept = 0
    for k in range(start[v], start[v] + node_count[v]):
        u = near_nodes[k]
        if size[u] > 0 and mark[u] != stamp:
            near_nodes[start[v] + kept] = u
            kept += 1
            beyond += size[u]
    node_count[v] = kept
    return beyond


@njit(cache=True, nogil=True)
def _merge_alike(
    tied, start, near_nodes, node_count, near_elements, element_count, size, degree, next_member, last_member,
    chain_head, chain_next,
):  # fmt: skip
    """Merge nodes that are next to the same nodes and elements; the merged one has size 0."""
    n = len(size)
    for u in tied:
        key = _key(u, start, near_nodes, node_count, near_elements, element_count) % n
        v = chain_head[key]
        while v >= 0:
            a, b = start[v], start[u]
            if _same_set(near_nodes[a : a + node_count[v]], near_nodes[b : b + node_count[u]]) and _same_set(
                near_elements[a : a + element_count[v]], near_elements[b : b + element_count[u]]
            ):
                break
            v = chain_next[v]
        if v < 0:
            chain_next[u], chain_head[key] = chain_head[key], u
            continue
        size[v] += size[u]
        degree[v] -= size[u]
        size[u] = 0
        next_member[last_member[v]] = u
        last_member[v] = last_member[u]
    for u in tied:
        chain_head[_key(u, start, near_nodes, node_count, near_elements, element_count) % n] = -1


@njit(cache=True, nogil=True)
def _key(v, start, near_nodes, node_count, near_elements, element_count):
    """A number that is the same for nodes that are next to the same nodes and elements."""
    key = node_count[v] + 7919 * element_count[v]
    for k in range(start[v], start[v] + node_count[v]):
        key += 31 * near_nodes[k] * near_nodes[k]
    for k in range(start[v], start[v] + element_count[v]):
        key += 17 * near_elements[k] * near_elements[k]
    return key


@njit(cache=True, nogil=True)
def _same_set(a, b):
    if len(a) != len(b):
        return False
    for x in a:
        found = False
        for y in b:
            if x == y:
                found = True
                break
        if not found:
            return False
    return True


@njit(cache=True, nogil=True)
def _grown(pool, end, length):
    """A longer array with the same first entries."""
    grown = np.empty(length, np.int64)
    for k in range(end):
        grown[k] = pool[k]
    return grown


@njit(cache=True, nogil=True)
def _insert(i, degree, head, following, previous):
    first = head[degree]
    following[i], previous[i] = first, -1
    if first >= 0:
        previous[first] = i
    head[degree] = i


@njit(cache=True, nogil=True)
def _remove(i, degree, head, following, previous):
    if previous[i] >= 0:
        following[previous[i]] = following[i]
    else:
        head[degree] = following[i]
    if following[i] >= 0:
        previous[following[i]] = previous[i]
