# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a socket's value comes from: through reroutes, muted nodes and groups."""


def output_node(tree, kind):
    """The active output of a tree for Cycles: `OUTPUT_MATERIAL`, `OUTPUT_WORLD`, `OUTPUT_LIGHT`; `None` without one."""
    found = None
    for node in tree.nodes:
        if node.type == kind and getattr(node, "target", "ALL") in {"ALL", "CYCLES"}:
            if getattr(node, "is_active_output", False):
                return node
            found = found or node
    return found


def find_source(socket, path):
    """`(node, output socket, path)` behind an input socket, or `(None, unlinked socket, path)`; `path` are the group nodes around it."""
    for _ in range(10_000):
        link = next((item for item in socket.links if item.is_valid and not item.is_muted), None) if socket.is_linked else None
        if link is None:
            return None, socket, path
        node, out = link.from_node, link.from_socket
        if node.type == "REROUTE":
            socket = node.inputs[0]
        elif node.mute:
            inner = next((item for item in node.internal_links if item.to_socket == out), None)
            if inner is None:
                return None, None, path
            socket = inner.from_socket
        elif node.type == "GROUP":
            tree = node.node_tree
            end = tree and next((n for n in tree.nodes if n.type == "GROUP_OUTPUT" and n.is_active_output), None)
            inside = end and _by_identifier(end.inputs, out.identifier)
            if not inside:
                return None, None, path
            socket, path = inside, (*path, node)
        elif node.type == "GROUP_INPUT" and path:
            outside = _by_identifier(path[-1].inputs, out.identifier)
            if outside is None:
                return None, None, path
            socket, path = outside, path[:-1]
        else:
            return node, out, path
    return None, None, path


def _by_identifier(sockets, identifier):
    return next((s for s in sockets if s.identifier == identifier), None)


def socket_of(node, name, from_outputs=False):
    """The input (or output) of that name or identifier: the first that is enabled, else the first; `None` without one."""
    sockets = node.outputs if from_outputs else node.inputs
    named = [s for s in sockets if s.name == name or s.identifier == name]
    return next((s for s in named if s.enabled), named[0] if named else None)


def plain_value(socket):
    """What an unlinked socket says: a number, or three of them."""
    if socket is None or not hasattr(socket, "default_value"):
        return 0.0
    value = socket.default_value
    if isinstance(value, (bool, int, float)):
        return float(value)
    if isinstance(value, str):
        return 0.0
    return [float(v) for v in value][:3]
